//! Verifies forward dynamics of the articulated plant, in f64: the accelerations under the files' torques.

use glam::{DMat3, DVec3};
use sinew_figure::plant::{
    ArticulatedPlant, Drive, JointModel, Link, MassProperties, Mechanism, MovingPose, Pose, link,
};

use super::case::{Case, State};
use crate::error::CaseError;
use crate::figure::{Root, parent};
use crate::golden::largest;
use crate::rounding::{DOUBLE, Motion};
use crate::tally::{Quantity, Tallies};

pub(super) fn check(
    case: &Case,
    state: &State,
    at: &str,
    rounded: &[Motion],
    tallies: &mut Tallies,
) -> Result<(), CaseError> {
    // A plant's root is free or bolted: a root that turns about a point is attached to an additional bolted body.
    let hung = case.root == Root::Spherical;
    let still =
        MovingPose { pose: Pose::IDENTITY, angular_rad_s: DVec3::ZERO, linear_m_s: DVec3::ZERO };
    let (mut bodies, mut start, mut torque_nm) = (vec![], vec![], vec![]);
    if hung {
        bodies.push(bolted());
        start.push(still);
        torque_nm.push(DVec3::ZERO);
    }
    for (index, golden) in case.bodies.iter().enumerate() {
        let of_case = parent(golden.parent, &format!("bodies[{index}]"))?;
        let parent = match of_case {
            Some(parent) => Some(parent + usize::from(hung)),
            None => hung.then_some(0),
        };
        let joint = match (parent, case.root) {
            (Some(_), _) => JointModel::Spherical,
            (None, Root::Free) => JointModel::Free,
            (None, _) => JointModel::Fixed,
        };
        bodies.push(link(parent, joint, golden.offset.0, &golden.mass_properties()));

        let before = parent.map_or(still, |parent: usize| start[parent]);
        let pose = before.pose.child(golden.offset.0, golden.rot.0 * state.quat[index].0);
        let angular_rad_s = before.angular_rad_s + pose.rotation * state.omega[index].0;
        start.push(MovingPose { pose, angular_rad_s, linear_m_s: DVec3::ZERO });
        torque_nm.push(pose.rotation * state.tau[index].0);
    }
    let mut drive = Drive { torque_nm, ..Drive::none(bodies.len()) };
    drive.force_n[0] = state.root_wrench.force_world.0;
    let got = ArticulatedPlant::new(&Mechanism { bodies, linked: Vec::new() }, &start, 0.01, 1)
        .map_err(|error| CaseError::new("bodies", error))?
        .with_gravity(case.gravity.0)
        .accelerations(&drive);

    // States of zero acceleration are compared on the scale of the other states.
    let scale = largest(case.states.iter().flat_map(|state| &state.alpha));
    // Both sides have been rounded, in f64.
    let limit = |rounded: f64| 2.0 * DOUBLE * rounded;
    let joints = &got.joints_rad_s2[usize::from(hung)..];
    for (body, (got, expected)) in joints.iter().zip(&state.alpha).enumerate() {
        let limit = limit(rounded[body].angular.limit());
        let quantity = Quantity { name: "joint acceleration, f64", unit: "rad/s²", limit, scale };
        tallies.add_error(
            quantity,
            format_args!("{at}, body {body}"),
            (*got - expected.0).length(),
        );
    }
    if let Some(root) = &state.root {
        let limit = limit(rounded[0].linear.limit());
        let quantity = Quantity { name: "root acceleration, f64", unit: "m/s²", limit, scale };
        let error = (got.root_m_s2 - root.root_lin_acc_world.0).length();
        tallies.add_error(quantity, format_args!("{at}"), error);
    }
    Ok(())
}

/// Returns a body that does not move. Its mass has no effect.
fn bolted() -> Link {
    let mass = MassProperties {
        mass_kg: 1.0,
        center_of_mass_m: DVec3::ZERO,
        rotational_kg_m2: DMat3::IDENTITY,
    };
    link(None, JointModel::Fixed, DVec3::ZERO, &mass)
}
