//! Verifies forward dynamics of the core: the accelerations under the files' torques, and zero acceleration under
//! the bias.

use sinew_core::dynamics::{ArticulatedBody, forward_dynamics};
use sinew_core::glam::Vec3;
use sinew_core::{JointState, Twist, Wrench};

use super::case::{Case, State, accelerations, bias_accelerations};
use crate::figure::Tree;
use crate::golden::{Vector, largest};
use crate::rounding::Motion;
use crate::tally::{Quantity, Tallies};

pub(super) fn check(
    case: &Case,
    tree: &Tree,
    state: &State,
    joints: &[JointState],
    at: &str,
    rounded: &[Vec<Motion>; 2],
    tallies: &mut Tallies,
) {
    let gravity = case.gravity.rounded();
    let run = |torques: &[Vector], root_force_n: Vec3| {
        let mut drives: Vec<_> =
            torques.iter().map(|torque| Wrench::new(torque.rounded(), Vec3::ZERO)).collect();
        drives[0].force_n = root_force_n;
        let mut workspace = vec![ArticulatedBody::default(); tree.len()];
        let mut out = vec![Twist::ZERO; tree.len()];
        forward_dynamics(tree.bodies(), joints, &drives, gravity, &[], &mut workspace, &mut out);
        out
    };
    let root_force = state.root_wrench.force_body.rounded();
    let bias_force = state.root.map_or(Vec3::ZERO, |root| root.bias_root_force_body.rounded());
    let of_torques = run(&state.tau, root_force);
    let of_bias = run(&state.bias, bias_force);

    // States of zero acceleration are compared on the scale of the other states.
    let scale = largest(case.states.iter().flat_map(|state| &state.alpha));
    for (name, got, rounded, expected) in [
        ("joint acceleration", of_torques, &rounded[0], accelerations(state)),
        ("joint acceleration of bias", of_bias, &rounded[1], bias_accelerations(state)),
    ] {
        for (body, ((got, [angular, linear]), rounded)) in
            got.iter().zip(expected).zip(rounded).enumerate()
        {
            let at = format_args!("{at}, body {body}");
            let quantity = |limit| Quantity { name, unit: "rad/s²", limit, scale };
            tallies.add(quantity(rounded.angular.limit()), at, got.angular, angular);
            // The expected linear acceleration is zero, except for a free root.
            tallies.add(quantity(rounded.linear.limit()), at, got.linear, linear);
        }
    }
}
