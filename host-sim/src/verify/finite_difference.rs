//! Finite differences of poses (`finite_difference/1`).

use serde::Deserialize;
use sinew_core::finite_difference::{Scheme, of_rotations, of_rotations_in_world, of_vectors};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::trajectory::{backward_states, forward_targets};
use sinew_core::{Body, Inertia, JointKind, JointStates, JointTargets, Transform, Tree};

use super::CaseError;
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::tally::{Quantity, Tallies};
use super::tolerance as limit;

#[derive(Deserialize)]
pub(super) struct Case {
    h: Scalar,
    quat: Vec<Rotation>,
    pos: Vec<Vector>,
    forward: Forward,
}

#[derive(Deserialize)]
struct Forward {
    omega_world: Vec<Vector>,
    omega_child: Vec<Vector>,
    lin_vel: Vec<Vector>,
    alpha_world: Vec<Vector>,
    alpha_child: Vec<Vector>,
    lin_acc: Vec<Vector>,
}

pub(super) fn check(name: &str, case: &Case, tallies: &mut Tallies) -> Result<(), CaseError> {
    let frames = case.quat.len();
    if frames < 3 {
        return Err(CaseError::new("quat", format!("{frames} frames, expected 3 or more")));
    }
    expect_count("pos", case.pos.len(), frames)?;
    let forward = &case.forward;
    for (field, list, order) in [
        ("omega_world", &forward.omega_world, 1),
        ("omega_child", &forward.omega_child, 1),
        ("lin_vel", &forward.lin_vel, 1),
        ("alpha_world", &forward.alpha_world, 2),
        ("alpha_child", &forward.alpha_child, 2),
        ("lin_acc", &forward.lin_acc, 2),
    ] {
        expect_count(&format!("forward.{field}"), list.len(), frames - order)?;
    }
    let at = format!("case {name}");
    check_differences(case, &at, tallies)?;
    check_trajectory(case, &at, tallies)
}

/// The differences by themselves. A backward one of frame k is the forward one of the frame `order` before.
fn check_differences(case: &Case, at: &str, tallies: &mut Tallies) -> Result<(), CaseError> {
    let rotations: Vec<Quat> = case.quat.iter().map(|quat| quat.rounded()).collect();
    let positions: Vec<Vec3> = case.pos.iter().map(|pos| pos.rounded()).collect();
    let (forward, h) = (&case.forward, case.h.rounded());
    for (scheme, scheme_name) in [(Scheme::Forward, "forward"), (Scheme::Backward, "backward")] {
        for (order, suffixes, limits, expected) in [
            (
                1,
                ["omega_world", "omega_child", "lin_vel"],
                [limit::DIFFERENCE_OMEGA, limit::DIFFERENCE_VELOCITY],
                [&forward.omega_world, &forward.omega_child, &forward.lin_vel],
            ),
            (
                2,
                ["alpha_world", "alpha_child", "lin_acc"],
                [limit::DIFFERENCE_ALPHA, limit::DIFFERENCE_ACCELERATION],
                [&forward.alpha_world, &forward.alpha_child, &forward.lin_acc],
            ),
        ] {
            let scales = expected.map(largest);
            for first in 0..rotations.len() - order {
                let (rotations, positions) =
                    (&rotations[first..=first + order], &positions[first..=first + order]);
                let got = [
                    of_rotations_in_world(scheme, order, rotations, h),
                    of_rotations(scheme, order, rotations, h),
                    of_vectors(scheme, order, positions, h),
                ];
                for (kind, got) in got.into_iter().enumerate() {
                    let got = got.map_err(|error| CaseError::new("quat", error))?;
                    let name = format!("{scheme_name} {}", suffixes[kind]);
                    let limit = limits[usize::from(kind == 2)];
                    let quantity = Quantity { name: &name, limit, scale: scales[kind] };
                    let at = format_args!("{at}, frame {first}");
                    tallies.add(quantity, at, got, expected[kind][first].0);
                }
            }
        }
    }
    Ok(())
}

/// The same through targets and measured states of one free joint, whose linear part is in body axes.
fn check_trajectory(case: &Case, at: &str, tallies: &mut Tallies) -> Result<(), CaseError> {
    let root = Body {
        parent: None,
        joint: JointKind::Free,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    let tree = Tree::<1>::from_bodies(&[root]).map_err(|error| CaseError::new("quat", error))?;
    let (mut targets, mut measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
    let poses: Vec<[Transform; 1]> = case
        .quat
        .iter()
        .zip(&case.pos)
        .map(|(quat, pos)| [Transform::new(quat.rounded(), pos.rounded())])
        .collect();
    let (forward, h) = (&case.forward, case.h.rounded());
    for (frame, window) in poses.windows(3).enumerate() {
        let [now, next, after] = [&window[0][..], &window[1][..], &window[2][..]];
        forward_targets([now, next, after], h, &mut targets)
            .and_then(|()| backward_states([now, next], h, &mut measured))
            .map_err(|error| CaseError::new(format!("quat[{frame}]"), error))?;
        let (desired, acceleration) = (targets.states()[0], targets.accelerations()[0]);
        let backward = measured.as_slice()[0];
        let (desired_to_world, measured_to_world) = (desired.pose.rotation, backward.pose.rotation);
        let mut add = |name, limit, got, expected: &[Vector]| {
            let quantity = Quantity { name, limit, scale: largest(expected) };
            tallies.add(quantity, format_args!("{at}, frame {frame}"), got, expected[frame].0);
        };
        let (omega, velocity) = (limit::DIFFERENCE_OMEGA, limit::DIFFERENCE_VELOCITY);
        let linear = desired_to_world * desired.velocity.linear;
        add("targets omega_child", omega, desired.velocity.angular, &forward.omega_child);
        add("targets lin_vel", velocity, linear, &forward.lin_vel);
        let linear = desired_to_world * acceleration.linear;
        add(
            "targets alpha_child",
            limit::DIFFERENCE_ALPHA,
            acceleration.angular,
            &forward.alpha_child,
        );
        add("targets lin_acc", limit::DIFFERENCE_ACCELERATION, linear, &forward.lin_acc);
        let linear = measured_to_world * backward.velocity.linear;
        add("measured omega_child", omega, backward.velocity.angular, &forward.omega_child);
        add("measured lin_vel", velocity, linear, &forward.lin_vel);
    }
    Ok(())
}
