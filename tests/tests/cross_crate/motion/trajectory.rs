//! Interpolation and finite differences, and their inverses.

use proptest::collection::vec;
use proptest::prelude::*;
use sinew_core::finite_difference::{Scheme, of_rotations, of_rotations_in_world, of_vectors};
use sinew_core::glam::{Quat, Vec3};
use sinew_core::trajectory::{
    aligned_targets, backward_states, interpolate, interpolate_smoothly, live_targets,
};
use sinew_core::{
    Body, Inertia, JointKind, JointStates, JointTargets, Trajectory, Transform, Tree, math,
};
use sinew_test_support::property;

const DT_S: f32 = 0.01;

/// Part of a frame over which a velocity of the smooth path is computed.
const STEP: f32 = 1e-2;

fn vector(size: f32) -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-size..size).prop_map(Vec3::from_array)
}

/// Any orientation, with either sign of its quaternion.
fn rotation() -> impl Strategy<Value = Quat> {
    (vector(2.0), any::<bool>()).prop_map(|(v, negate)| {
        let q = math::exp(v);
        if negate { -q } else { q }
    })
}

fn pose() -> impl Strategy<Value = Transform> {
    (rotation(), vector(2.0)).prop_map(|(rotation, way)| Transform::new(rotation, way))
}

/// Frames, each turned by up to 0.17 rad and moved by up to 9 cm from the previous one.
fn frames() -> impl Strategy<Value = Vec<Transform>> {
    (pose(), vec((vector(0.1), vector(0.05), any::<bool>()), 3..12)).prop_map(|(first, steps)| {
        let mut frames = vec![first];
        for (turn, way, negate) in steps {
            let last = frames[frames.len() - 1];
            let rotation = math::unit(last.rotation * math::exp(turn));
            let rotation = if negate { -rotation } else { rotation };
            frames.push(Transform::new(rotation, last.translation_m + way));
        }
        frames
    })
}

fn angle_between(a: Quat, b: Quat) -> f32 {
    math::length(math::log(a.conjugate() * b))
}

fn one_joint() -> Tree<1> {
    let root = Body {
        parent: None,
        joint: JointKind::Free,
        placement: Transform::IDENTITY,
        inertia: Inertia::default(),
        rotor_inertia: 0.0,
    };
    Tree::from_bodies(&[root]).expect("a good body")
}

proptest! {
    #![proptest_config(property(500))]

    #[test]
    fn interpolation_meets_both_ends_and_goes_evenly(
        (from, to, t) in (pose(), pose(), 0.0f32..1.0),
    ) {
        let whole = angle_between(from.rotation, to.rotation);
        prop_assume!(whole < 3.1, "half a turn has no shorter way");
        let start = interpolate(&from, &to, 0.0);
        let end = interpolate(&from, &to, 1.0);
        prop_assert!(angle_between(start.rotation, from.rotation) < 1e-6);
        prop_assert!(angle_between(end.rotation, to.rotation) < 1e-6);
        prop_assert_eq!(start.translation_m, from.translation_m);
        prop_assert!((end.translation_m - to.translation_m).abs().max_element() < 1e-6);
        let between = interpolate(&from, &to, t);
        // An angle near π has the error of its cosine, 1e-7, divided by its sine.
        let allowed = 1e-6 / (0.5 * (3.1 - whole)).min(1.0);
        prop_assert!((angle_between(from.rotation, between.rotation) - t * whole).abs() < allowed);
        prop_assert!((angle_between(between.rotation, to.rotation) - (1.0 - t) * whole).abs() < allowed);
        let length = between.rotation.length();
        prop_assert!((length - 1.0).abs() < 2e-7, "length {length}");
    }

    #[test]
    fn a_velocity_leads_from_frame_to_frame(frames in frames()) {
        for pair in frames.windows(2) {
            let rotations = [pair[0].rotation, pair[1].rotation];
            let positions = [pair[0].translation_m, pair[1].translation_m];
            for scheme in [Scheme::Forward, Scheme::Backward] {
                let in_body = of_rotations(scheme, 1, &rotations, DT_S).expect("good frames");
                let in_world = of_rotations_in_world(scheme, 1, &rotations, DT_S).expect("good frames");
                let linear = of_vectors(scheme, 1, &positions, DT_S).expect("good frames");
                let next = rotations[0] * math::exp(in_body * DT_S);
                prop_assert!(angle_between(next, rotations[1]) < 1e-6);
                let next = math::exp(in_world * DT_S) * rotations[0];
                prop_assert!(angle_between(next, rotations[1]) < 1e-6);
                let next = positions[0] + linear * DT_S;
                prop_assert!((next - positions[1]).abs().max_element() < 1e-6);
            }
        }
    }

    #[test]
    fn an_acceleration_is_the_difference_of_velocities(frames in frames()) {
        for window in frames.windows(3) {
            let rotations = [0, 1, 2].map(|k: usize| window[k].rotation);
            let velocity = |k: usize| of_rotations(Scheme::Forward, 1, &rotations[k..=k + 1], DT_S);
            let (first, second) = (velocity(0).expect("good"), velocity(1).expect("good"));
            for scheme in [Scheme::Forward, Scheme::Backward, Scheme::Central] {
                let got = of_rotations(scheme, 2, &rotations, DT_S).expect("good frames");
                prop_assert_eq!(got, (second - first) / DT_S);
            }
            let central = of_rotations(Scheme::Central, 1, &rotations, DT_S).expect("good frames");
            prop_assert!((central - (first + second) * 0.5).abs().max_element() < 1e-5);
        }
    }

    #[test]
    fn frames_come_back_at_their_times(frames in frames()) {
        let trajectory = Trajectory::new(&frames, 1, DT_S).expect("good frames");
        for (index, frame) in frames.iter().enumerate() {
            let mut sampled = [Transform::IDENTITY];
            trajectory.sample(index as f32 * DT_S, &mut sampled);
            // The time has a rounding error: 1e-6 of a step of 0.2 rad and 5 cm.
            prop_assert!(angle_between(sampled[0].rotation, frame.rotation) < 2e-6);
            prop_assert!((sampled[0].translation_m - frame.translation_m).abs().max_element() < 1e-6);
        }
    }

    #[test]
    fn what_is_measured_at_a_frame_was_the_target_one_frame_before(frames in frames()) {
        let tree = one_joint();
        let trajectory = Trajectory::new(&frames, 1, DT_S).expect("good frames");
        let (mut targets, mut measured) = (JointTargets::rest(&tree), JointStates::rest(&tree));
        for index in 0..frames.len() - 2 {
            trajectory.targets(index, &mut targets).expect("good frames");
            let window = [trajectory.frame(index), trajectory.frame(index + 1)];
            backward_states(window, DT_S, &mut measured).expect("good frames");
            let (target, measured) = (targets.states()[0], measured.as_slice()[0]);
            // In a steady turn the body axes of both ends give the same components.
            prop_assert_eq!(target.velocity.angular, measured.velocity.angular);
            let (forward, backward) = (
                target.pose.rotation * target.velocity.linear,
                measured.pose.rotation * measured.velocity.linear,
            );
            prop_assert!((forward - backward).abs().max_element() < 1e-5, "m/s in the parent's axes");
        }
    }

    #[test]
    fn differences_of_a_polynomial_are_its_derivative(
        (order, coefficients, at) in (1usize..5, vec(-3i8..=3, 5), -4i8..=4),
    ) {
        // Integers, so that f32 is exact: p(t) of degree `order`, whose derivative of that order is order! times its
        // first coefficient.
        let value = |t: f32| coefficients[..=order].iter().fold(0.0, |sum, c| sum * t + f32::from(*c));
        let factorial = (1..=order).fold(1.0, |product, k| product * k as f32);
        for scheme in [Scheme::Forward, Scheme::Backward, Scheme::Central] {
            let samples: Vec<_> = (0..scheme.sample_count(order))
                .map(|k| Vec3::splat(value(f32::from(at) + k as f32)))
                .collect();
            let got = of_vectors(scheme, order, &samples, 1.0).expect("good samples");
            prop_assert_eq!(got, Vec3::splat(factorial * f32::from(coefficients[0])));
        }
    }

    /// A rig was at the previous frame and is at the present one. If it has the acceleration of aligned targets for
    /// one period, and its velocity is updated before its pose, it reaches the next frame.
    #[test]
    fn aligned_targets_lead_to_the_next_frame(frames in frames()) {
        let tree = one_joint();
        let mut targets = JointTargets::rest(&tree);
        for window in frames.windows(3) {
            let frames = [0, 1, 2].map(|k| &window[k..=k]);
            aligned_targets(frames, DT_S, &mut targets).unwrap();
            let (state, a) = (targets.states()[0], targets.accelerations()[0]);
            let angular = state.velocity.angular + a.angular * DT_S;
            let linear = state.velocity.linear + a.linear * DT_S;
            let rotation = state.pose.rotation * math::exp(angular * DT_S);
            let position = state.pose.translation_m + state.pose.rotation * linear * DT_S;
            // Rounding of unit quaternions and of positions of up to 2.5 m, a few times.
            prop_assert!(angle_between(rotation, window[2].rotation) < 2e-6);
            prop_assert!(math::length(position - window[2].translation_m) < 2e-6);
        }
    }

    /// Live targets use only the last step and the change from the step before it.
    #[test]
    fn live_targets_know_nothing_of_the_next_frame(frames in frames()) {
        let tree = one_joint();
        let mut targets = JointTargets::rest(&tree);
        for window in frames.windows(3) {
            live_targets([0, 1, 2].map(|k| &window[k..=k]), DT_S, &mut targets).unwrap();
            let rotations = [0, 1, 2].map(|k| window[k].rotation);
            let (state, a) = (targets.states()[0], targets.accelerations()[0]);
            let velocity = of_rotations(Scheme::Backward, 1, &rotations[1..], DT_S).unwrap();
            let acceleration = of_rotations(Scheme::Backward, 2, &rotations, DT_S).unwrap();
            // The products of unit quaternions are added in another order: a few roundings of 1, divided by the
            // period; and of the velocity, times the rate or divided by the period.
            let close = |a: Vec3, b: Vec3, of: f32| (a - b).length() <= 4.0 * f32::EPSILON * of;
            let faster = velocity.length().max((velocity - acceleration * DT_S).length());
            let of = faster + 1.0 / DT_S;
            prop_assert!(close(state.velocity.angular, velocity, of));
            prop_assert!(close(a.angular, acceleration, 2.0 * of / DT_S));
        }
    }

    /// The smooth path goes through all frames, and its velocity is continuous at them.
    #[test]
    fn the_smooth_path_has_one_velocity_at_every_frame(frames in frames()) {
        for window in frames.windows(5) {
            let [a, b, c, d, e] = [0, 1, 2, 3, 4].map(|k| &window[k]);
            let (coming, going) = ([a, b, c, d], [b, c, d, e]);
            prop_assert!(angle_between(interpolate_smoothly(coming, 0.0).rotation, b.rotation) < 1e-6);
            prop_assert!(angle_between(interpolate_smoothly(coming, 1.0).rotation, c.rotation) < 1e-6);
            let end = interpolate_smoothly(coming, 1.0).translation_m;
            prop_assert!(math::length(end - c.translation_m) < 1e-6);
            let before = interpolate_smoothly(coming, 1.0 - STEP);
            let after = interpolate_smoothly(going, STEP);
            let arrives = math::log(before.rotation.conjugate() * c.rotation) / STEP;
            let leaves = math::log(c.rotation.conjugate() * after.rotation) / STEP;
            // Second derivatives are at most about 6 times a frame's step (0.2 rad, 0.1 m), on either side, and the
            // inverse Jacobian is exact to 1e-4; rounding is 1e-7 / STEP.
            prop_assert!(math::length(arrives - leaves) < 12.0 * 0.2 * STEP, "{arrives} {leaves}");
            let arrives = (c.translation_m - before.translation_m) / STEP;
            let leaves = (after.translation_m - c.translation_m) / STEP;
            prop_assert!(math::length(arrives - leaves) < 12.0 * 0.1 * STEP, "{arrives} {leaves}");
        }
    }
}
