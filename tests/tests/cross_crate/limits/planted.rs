//! Deliberate errors are found: the limits are not too wide.

use sinew_core::glam::Vec3;
use sinew_core::{Body, JointState, Tree, Twist};
use sinew_test_support::rig::{CAPACITY, Rig};
use sinew_test_support::rounded::motions;
use sinew_verification::rounding::Vector;

use super::case::Case;
use super::dynamics::{GRAVITY_M_S2, Sides};

/// Number of rigs in which each error is planted.
const RIGS: u64 = 60;

/// Returns whether a wrench of a wrong rig, or of a wrong motion, exceeds the limit for the right rig and motion.
fn found(right: &Sides, wrong: &Rig, states: &[JointState], accelerations: &[Twist]) -> bool {
    let got = wrong.wrenches(states, accelerations, GRAVITY_M_S2, &[]);
    let rounded = right.rounded_wrenches(&motions(&right.rig.accelerations()));
    got.iter().zip(&rounded).any(|(got, rounded)| {
        let off = |got: Vec3, rounded: &Vector| {
            (got.as_dvec3() - rounded.exact()).length() > rounded.limit()
        };
        off(got.moment_nm, &rounded.angular) || off(got.force_n, &rounded.linear)
    })
}

/// Counts the rigs in which an error of the last body, which has no children, is found.
fn found_in(plant: impl Fn(&mut Body)) -> usize {
    let is_found = |number: &u64| {
        let right = Sides::new(Case::new(*number).rig());
        let mut bodies = right.rig.tree.bodies().to_vec();
        plant(bodies.last_mut().expect("a rig has bodies"));
        let tree = Tree::<CAPACITY>::from_bodies(&bodies).expect("still a rig");
        let wrong = Rig { tree, motions: right.rig.motions.clone() };
        found(&right, &wrong, &right.states, &right.rig.accelerations())
    };
    (0..RIGS).filter(is_found).count()
}

#[test]
fn a_right_rig_is_within_its_limits() {
    assert_eq!(found_in(|_| {}), 0);
}

/// In 99 of 100 rigs a force has a limit of 2e-5 of the largest force or less (the table of `cargo xtask limits`). An
/// error that is five times as large is found in every rig.
#[test]
fn a_mass_off_by_a_ten_thousandth_is_found() {
    assert_eq!(found_in(|body| body.inertia.mass_kg *= 1.000_1), 60);
}

/// 20 um are a ten-thousandth of 0.2 m, the largest distance of a centre of mass from its body's origin.
#[test]
fn a_centre_of_mass_off_by_20_um_is_found() {
    assert_eq!(found_in(|body| body.inertia.center_of_mass_m += Vec3::splat(2e-5)), 60);
}

#[test]
fn a_speed_off_by_a_ten_thousandth_is_found() {
    let is_found = |right: Sides| {
        let mut states = right.states.clone();
        for state in &mut states {
            state.velocity.angular *= 1.000_1;
            state.velocity.linear *= 1.000_1;
        }
        found(&right, &right.rig, &states, &right.rig.accelerations())
    };
    // If no joint turns, speeds cause no force.
    let turns =
        |right: &Sides| right.states.iter().any(|state| state.velocity.angular != Vec3::ZERO);
    let right = (0..RIGS).map(|number| Sides::new(Case::new(number).rig()));
    let found: Vec<bool> = right.filter(turns).map(is_found).collect();
    assert!(found.len() > 50 && found.iter().all(|found| *found), "{found:?}");
}
