//! Tests of mechanisms that take their steps together.

use std::array::from_fn;

use sinew_host_util::random::{Random, Subject};

use super::*;
use crate::plant::articulated::turn::{small_turn, unit};

/// Returns the bits of all numbers; all that are not a number are equal.
fn bits(poses: &[Pose]) -> Vec<u64> {
    let numbers = |pose: &Pose| {
        let ([x, y, z, w], position_m) = (pose.rotation.to_array(), pose.position_m.to_array());
        [x, y, z, w].into_iter().chain(position_m)
    };
    poses
        .iter()
        .flat_map(numbers)
        .map(|x| if x.is_nan() { u64::MAX } else { x.to_bits() })
        .collect()
}

/// Checks that mechanisms have the same poses together as alone, to the last bit, in 100 steps.
fn are_the_same_together(rigs: &[(Mechanism, Vec<MovingPose>); LANES], dt_s: f64) {
    let mut alone = rigs
        .each_ref()
        .map(|(mechanism, start)| ArticulatedPlant::new(mechanism, start, dt_s, 2).unwrap());
    let mut together = ArticulatedPlant::join(alone.each_ref()).unwrap();
    for step in 0..100 {
        let drives = from_fn::<_, LANES, _>(|lane| random_torques(1 + step + 100 * lane as u64));
        together.step_all(drives.each_ref());
        for (lane, (plant, drive)) in alone.iter_mut().zip(&drives).enumerate() {
            plant.step(drive);
            assert_eq!(bits(together.poses_of(lane)), bits(plant.poses()), "{step} {lane}");
        }
    }
    assert!(alone.iter().skip(1).all(|plant| plant.poses()[17].rotation.is_finite()));
}

#[test]
fn ball_joints_move_together_as_alone() {
    for root in [JointModel::Free, JointModel::Fixed, JointModel::Spherical] {
        are_the_same_together(&from_fn(|lane| random_tree(root, 1 + lane as u64)), 0.002);
    }
}

#[test]
fn a_mechanism_that_turns_far_in_a_step_does_not_change_the_others() {
    let rigs = from_fn(|lane| {
        let (mechanism, mut start) = random_tree(JointModel::Free, 1 + lane as u64);
        if lane == 0 {
            start[17].angular_rad_s *= 1000.0;
        }
        (mechanism, start)
    });
    are_the_same_together(&rigs, 0.002);
}

#[test]
fn mechanisms_with_other_joints_are_not_joined() {
    let plant = |joint, dt_s| {
        let body = solid(1.0, DVec3::Y * 0.1, diagonal(0.01, 0.01, 0.01));
        let mut mechanism = hung(body);
        mechanism.bodies[1].joint = joint;
        let start = [at_rest(DVec3::ZERO, DQuat::IDENTITY); 2];
        ArticulatedPlant::new(&mechanism, &start, dt_s, 1).unwrap()
    };
    let ball = plant(JointModel::Spherical, 0.01);
    let others = [plant(JointModel::Revolute(DVec3::X), 0.01), plant(JointModel::Spherical, 0.02)];
    assert!(ArticulatedPlant::join([&ball; LANES]).is_some());
    for other in others.iter().chain([&ball.clone().with_gravity(DVec3::ZERO)]) {
        let plants = from_fn(|lane| if lane == 5 { other } else { &ball });
        assert!(ArticulatedPlant::join(plants).is_none());
    }
}

#[test]
fn small_turns_have_the_bits_of_glam() {
    let mut random = Random::new(1, Subject::Noise);
    let mut largest = 0.0_f64;
    for round in 0..20_000 {
        // Lengths from far below the resolution of an angle to a little beyond the limit.
        let v =
            random.normal3().normalize() * 2.0_f64.powi(-(round % 80)) * random.between(0.8, 1.7);
        let (turn, is_small) = small_turn(v);
        if is_small {
            largest = largest.max(v.length());
            assert_eq!(
                turn.to_array().map(f64::to_bits),
                DQuat::from_scaled_axis(v).to_array().map(f64::to_bits),
                "{v}"
            );
        }
        let q = turn * random.between(0.5, 1.5);
        assert_eq!(
            unit(q).to_array().map(f64::to_bits),
            q.normalize().to_array().map(f64::to_bits),
            "{q}"
        );
    }
    assert!(largest > 1.5, "{largest}");
    assert!(!small_turn(DVec3::X * 1.58).1 && !small_turn(DVec3::NAN).1);
    assert_eq!(small_turn(DVec3::ZERO), (DQuat::IDENTITY, true));
}
