//! Verifies finite differences of poses (`finite_difference/1`).

use serde::Deserialize;
use sinew_core::finite_difference::{Scheme, of_rotations, of_rotations_in_world, of_vectors};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::trajectory::{backward_states, forward_targets};
use sinew_core::{Body, Inertia, JointKind, JointStates, JointTargets, Transform, Tree};

use super::error::CaseError;
use super::golden::{Rotation, Scalar, Vector, expect_count, largest};
use super::rounding::{self, Number};
use super::tally::{Quantity, Tallies};

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

/// Checks the differences alone. A backward difference at frame k is the forward difference `order` frames before.
fn check_differences(case: &Case, at: &str, tallies: &mut Tallies) -> Result<(), CaseError> {
    let rotations: Vec<Quat> = case.quat.iter().map(|quat| quat.rounded()).collect();
    let positions: Vec<Vec3> = case.pos.iter().map(|pos| pos.rounded()).collect();
    let (forward, h) = (&case.forward, case.h.rounded());
    let rounded = Rounded::new(case);
    for (scheme, scheme_name) in [(Scheme::Forward, "forward"), (Scheme::Backward, "backward")] {
        for (order, names, expected) in [
            (
                1,
                [("omega_world", "rad/s"), ("omega_child", "rad/s"), ("lin_vel", "m/s")],
                [&forward.omega_world, &forward.omega_child, &forward.lin_vel],
            ),
            (
                2,
                [("alpha_world", "rad/s²"), ("alpha_child", "rad/s²"), ("lin_acc", "m/s²")],
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
                    let (suffix, unit) = names[kind];
                    let name = format!("{scheme_name} {suffix}");
                    let limit = rounded.of_order(order, kind, first).limit();
                    let quantity = Quantity { name: &name, unit, limit, scale: scales[kind] };
                    let at = format_args!("{at}, frame {first}");
                    tallies.add(quantity, at, got, expected[kind][first].0);
                }
            }
        }
    }
    Ok(())
}

/// Velocities with their rounding, indexed by kind (of the rotation in world axes, of the rotation in body axes, of the
/// position) and by frame.
struct Rounded {
    orientations: Vec<rounding::Rotation>,
    velocities: [Vec<rounding::Vector>; 3],
    rate: Number,
}

impl Rounded {
    fn new(case: &Case) -> Self {
        let rate = Number::known(1.0) / Number::given(case.h.0);
        let orientations: Vec<_> =
            case.quat.iter().map(|quat| rounding::Rotation::given(quat.0)).collect();
        let positions: Vec<_> = case.pos.iter().map(|pos| rounding::Vector::given(pos.0)).collect();
        let turns = |turn: &dyn Fn(&[rounding::Rotation]) -> rounding::Rotation| {
            orientations.windows(2).map(|pair| turn(pair).log() * rate).collect()
        };
        let velocities = [
            turns(&|pair| pair[1].after(pair[0].inverse())),
            turns(&|pair| pair[0].inverse().after(pair[1])),
            positions.windows(2).map(|pair| (pair[1] - pair[0]) * rate).collect(),
        ];
        Self { orientations, velocities, rate }
    }

    fn of_order(&self, order: usize, kind: usize, frame: usize) -> rounding::Vector {
        let velocities = &self.velocities[kind];
        match order {
            1 => velocities[frame],
            _ => (velocities[frame + 1] - velocities[frame]) * self.rate,
        }
    }

    /// Returns a linear quantity, converted to the axes of a frame's body and back.
    fn there_and_back(&self, order: usize, frame: usize, axes: usize) -> rounding::Vector {
        let axes = self.orientations[axes];
        axes.turn(axes.inverse().turn(self.of_order(order, 2, frame)))
    }
}

/// Checks the differences through targets and measured states of one free joint, whose linear part is in body
/// axes.
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
    let rounded = Rounded::new(case);
    for (frame, window) in poses.windows(3).enumerate() {
        let [now, next, after] = [&window[0][..], &window[1][..], &window[2][..]];
        forward_targets([now, next, after], h, &mut targets)
            .and_then(|()| backward_states([now, next], h, &mut measured))
            .map_err(|error| CaseError::new(format!("quat[{frame}]"), error))?;
        let (desired, acceleration) = (targets.states()[0], targets.accelerations()[0]);
        let backward = measured.as_slice()[0];
        let (desired_to_world, measured_to_world) = (desired.pose.rotation, backward.pose.rotation);
        let mut add = |name, unit, rounded: rounding::Vector, got, expected: &[Vector]| {
            let limit = rounded.limit();
            let quantity = Quantity { name, unit, limit, scale: largest(expected) };
            tallies.add(quantity, format_args!("{at}, frame {frame}"), got, expected[frame].0);
        };
        let (turn, way) = (rounded.of_order(1, 1, frame), rounded.there_and_back(1, frame, frame));
        let linear = desired_to_world * desired.velocity.linear;
        add("targets omega_child", "rad/s", turn, desired.velocity.angular, &forward.omega_child);
        add("targets lin_vel", "m/s", way, linear, &forward.lin_vel);
        let linear = desired_to_world * acceleration.linear;
        let alpha = rounded.of_order(2, 1, frame);
        add("targets alpha_child", "rad/s²", alpha, acceleration.angular, &forward.alpha_child);
        let of_way = rounded.there_and_back(2, frame, frame);
        add("targets lin_acc", "m/s²", of_way, linear, &forward.lin_acc);
        let linear = measured_to_world * backward.velocity.linear;
        let way = rounded.there_and_back(1, frame, frame + 1);
        add("measured omega_child", "rad/s", turn, backward.velocity.angular, &forward.omega_child);
        add("measured lin_vel", "m/s", way, linear, &forward.lin_vel);
    }
    Ok(())
}
