//! Kinematics, inverse and forward dynamics and the mass matrix of rigs with joints of all kinds.

use sinew_core::dynamics::{
    ArticulatedBody, CompositeBody, dof_count, forward_dynamics, mass_matrix,
};
use sinew_core::glam::{DVec3, Vec3};
use sinew_core::{JointState, Twist};
use sinew_test_support::rig::Rig;
use sinew_test_support::rounded::{Rounded, motions};
use sinew_verification::rounding::{self, Motion, Number, Vector};

use super::case::Case;
use super::tally::{Quantity, Table};

pub(crate) const GRAVITY_M_S2: Vec3 = Vec3::new(0.3, -9.7, 1.1);

/// A rig as the core uses it, and with its rounding.
pub(crate) struct Sides {
    pub(crate) rig: Rig,
    pub(crate) states: Vec<JointState>,
    pub(crate) rounded: Rounded,
}

impl Sides {
    pub(crate) fn new(rig: Rig) -> Self {
        let states = rig.states().as_slice().to_vec();
        let rounded = Rounded::of_states(rig.tree.bodies(), &states);
        Self { rig, states, rounded }
    }

    /// Returns the wrenches of the joints for these accelerations, with their rounding.
    pub(crate) fn rounded_wrenches(&self, accelerations: &[Motion]) -> Vec<Motion> {
        let Rounded { links, joints } = &self.rounded;
        rounding::inverse_dynamics(links, joints, accelerations, Vector::known(GRAVITY_M_S2))
    }
}

pub(crate) fn compare(case: &Case, table: &mut Table) {
    let sides = Sides::new(case.rig());
    kinematics(&sides, table);
    torques(&sides, table);
    matrix(&sides, table);
    accelerations(&sides, table);
}

/// Compares a list of vectors with the list that carries its rounding.
pub(crate) fn vectors(
    table: &mut Table,
    [name, unit]: [&'static str; 2],
    got: impl IntoIterator<Item = Vec3>,
    rounded: impl IntoIterator<Item = Vector> + Clone,
) {
    let length = |vector: Vector| vector.exact().length();
    let scale = rounded.clone().into_iter().map(length).fold(0.0, f64::max);
    for (body, (got, rounded)) in got.into_iter().zip(rounded).enumerate() {
        let error = (got.as_dvec3() - rounded.exact()).length();
        let quantity = Quantity { name, unit, scale };
        table.add(quantity, format_args!("body {body}"), error, rounded.limit());
    }
}

fn kinematics(sides: &Sides, table: &mut Table) {
    let world = sides.rig.world();
    let rounded = sides.rounded.world();
    for (body, (got, rounded)) in world.iter().zip(&rounded).enumerate() {
        let off = got.pose.rotation.as_dquat().normalize() * rounded.rotation.exact().inverse();
        let error = 2.0 * DVec3::new(off.x, off.y, off.z).length().atan2(off.w.abs());
        let quantity = Quantity { name: "world rotation", unit: "rad", scale: 1.0 };
        table.add(quantity, format_args!("body {body}"), error, rounded.rotation.limit());
    }
    let of = |name,
              unit,
              got: fn(&sinew_core::BodyState) -> Vec3,
              with: fn(&rounding::State) -> Vector| { (name, unit, got, with) };
    for (name, unit, got, with) in [
        of("world position", "m", |s| s.pose.translation_m, |s| s.position),
        of("world angular velocity", "rad/s", |s| s.velocity.angular, |s| s.velocity.angular),
        of("world linear velocity", "m/s", |s| s.velocity.linear, |s| s.velocity.linear),
    ] {
        vectors(table, [name, unit], world.iter().map(got), rounded.iter().map(with));
    }
}

fn torques(sides: &Sides, table: &mut Table) {
    let accelerations = sides.rig.accelerations();
    let got = sides.rig.wrenches(&sides.states, &accelerations, GRAVITY_M_S2, &[]);
    let rounded = sides.rounded_wrenches(&motions(&accelerations));
    let (moments, forces) =
        (got.iter().map(|wrench| wrench.moment_nm), got.iter().map(|wrench| wrench.force_n));
    vectors(table, ["joint moment", "N m"], moments, rounded.iter().map(|motion| motion.angular));
    vectors(table, ["joint force", "N"], forces, rounded.iter().map(|motion| motion.linear));
}

fn matrix(sides: &Sides, table: &mut Table) {
    let bodies = sides.rig.tree.bodies();
    let mut got = vec![0.0; dof_count(bodies).pow(2)];
    let mut scratch = vec![CompositeBody::default(); bodies.len()];
    let size = mass_matrix(bodies, &sides.states, &mut scratch, &mut got);
    let Rounded { links, joints } = &sides.rounded;
    let rounded = rounding::mass_matrix(links, joints);
    elements(table, "H", &rounded, |row, column| f64::from(got[row * size + column]));

    let columns = sides.rig.mass_matrix_by_torques();
    let rounded = rounding::mass_matrix_by_torques(links, joints);
    elements(table, "H, by torques", &rounded, |row, column| columns[row][column]);
}

fn elements(
    table: &mut Table,
    name: &'static str,
    rounded: &[Vec<Number>],
    got: impl Fn(usize, usize) -> f64,
) {
    for (row, numbers) in rounded.iter().enumerate() {
        for (column, number) in numbers.iter().enumerate() {
            // H is positive definite: no element exceeds the geometric mean of its two diagonal elements.
            let scale = (rounded[row][row].exact() * rounded[column][column].exact()).sqrt();
            let quantity = Quantity { name, unit: "kg m²", scale };
            let error = got(row, column) - number.exact();
            table.add(quantity, format_args!("[{row}][{column}]"), error, number.limit());
        }
    }
}

fn accelerations(sides: &Sides, table: &mut Table) {
    let bodies = sides.rig.tree.bodies();
    // Drives that are as large as the rig's motion requires.
    let drives = sides.rig.wrenches(&sides.states, &sides.rig.accelerations(), GRAVITY_M_S2, &[]);
    let mut workspace = vec![ArticulatedBody::default(); bodies.len()];
    let mut got = vec![Twist::ZERO; bodies.len()];
    forward_dynamics(bodies, &sides.states, &drives, GRAVITY_M_S2, &[], &mut workspace, &mut got);
    let of_drives: Vec<_> = drives
        .iter()
        .map(|drive| Motion {
            angular: Vector::known(drive.moment_nm),
            linear: Vector::known(drive.force_n),
        })
        .collect();
    let gravity = Vector::known(GRAVITY_M_S2);
    let Rounded { links, joints } = &sides.rounded;
    let rounded = rounding::forward_dynamics(links, joints, &of_drives, gravity);
    let (angular, linear) = (got.iter().map(|a| a.angular), got.iter().map(|a| a.linear));
    let with = ["joint acceleration, angular", "rad/s²"];
    vectors(table, with, angular, rounded.iter().map(|a| a.angular));
    let with = ["joint acceleration, linear", "m/s²"];
    vectors(table, with, linear, rounded.iter().map(|a| a.linear));
}
