#![expect(clippy::cast_possible_truncation, reason = "rounds to the network's f32")]

use candle_core::{Device, Var};
use glam::DQuat;
use sinew_figure::builtin;
use sinew_host_util::random::{Random, Subject};

use super::*;
use crate::autoencoder::data::forward_kinematics;
use crate::autoencoder::two_columns;

fn skeleton() -> Skeleton {
    builtin::clips().swap_remove(0).skeleton
}

/// Returns arbitrary rotations, and their columns, scaled and skewed.
fn poses(joints: usize, count: usize) -> (Vec<Vec<DQuat>>, Tensor) {
    let mut random = Random::new(11, Subject::Noise);
    let mut columns = Vec::new();
    let poses = (0..count).map(|_| {
        let rotation = |_| {
            let rotation = DQuat::from_scaled_axis(random.normal3());
            let [ax, ay, az, bx, by, bz] = two_columns::from_rotation(rotation);
            let (long, lean) = (random.between(0.7, 1.4), random.between(-0.3, 0.3));
            let lengthened = [ax, ay, az, bx + lean * ax, by + lean * ay, bz + lean * az];
            columns.extend(lengthened.map(|x| (long * x) as f32));
            rotation
        };
        (0..joints).map(rotation).collect()
    });
    let poses: Vec<Vec<DQuat>> = poses.collect();
    let columns = Tensor::from_vec(columns, (count, 6 * joints), &Device::Cpu).unwrap();
    (poses, columns)
}

#[test]
fn every_form_agrees_with_the_kinematics_in_f64() {
    let skeleton = skeleton();
    let joints = skeleton.joints.len();
    let (poses, columns) = poses(joints, 7);
    for form in Form::ALL {
        let kinematics = Kinematics::new(&skeleton, form).unwrap();
        let global = kinematics.global(&columns).unwrap().to_vec2::<f32>().unwrap();
        for (pose, global) in poses.iter().zip(&global) {
            let expected = forward_kinematics(&skeleton, pose);
            for (joint, found) in expected.iter().zip(global.chunks_exact(9)) {
                let columns = two_columns::from_rotation(joint.rotation);
                for (expected, found) in
                    joint.position_m.to_array().iter().chain(&columns).zip(found)
                {
                    // Five rotations in f32 on the path to a hand.
                    let off = expected - f64::from(*found);
                    assert!(off.abs() < 3e-6, "{form:?}: {expected} {found}");
                }
            }
        }
    }
}

/// Returns a weighted sum over all results, each with its own factor, and its gradient with respect to the columns.
fn weighted(kinematics: &Kinematics, columns: &Tensor) -> (Tensor, Tensor) {
    let columns = Var::from_tensor(columns).unwrap();
    let global = kinematics.global(&columns).unwrap();
    let mut random = Random::new(5, Subject::Noise);
    let factors: Vec<f32> =
        (0..global.elem_count()).map(|_| random.between(-1.0, 1.0) as f32).collect();
    let factors = Tensor::from_vec(factors, global.shape(), &Device::Cpu).unwrap();
    let sum = (global * factors).unwrap().sum_all().unwrap();
    let gradients = sum.backward().unwrap();
    (sum, gradients.get(&columns).unwrap().clone())
}

fn values(tensor: &Tensor) -> Vec<f32> {
    tensor.flatten_all().unwrap().to_vec1().unwrap()
}

#[test]
fn the_gradient_worked_out_by_hand_is_the_frameworks() {
    let skeleton = skeleton();
    let (_, columns) = poses(skeleton.joints.len(), 5);
    let [by_joint, by_level, fused] = Form::ALL
        .map(|form| values(&weighted(&Kinematics::new(&skeleton, form).unwrap(), &columns).1));
    for other in [by_level, fused] {
        for (a, b) in by_joint.iter().zip(&other) {
            assert!((a - b).abs() < 2e-5 * (1.0 + a.abs()), "{a} {b}");
        }
    }
}

#[test]
fn the_gradient_is_the_slope() {
    const STEP: f32 = 4e-3;
    let skeleton = skeleton();
    let (_, columns) = poses(skeleton.joints.len(), 1);
    for form in [Form::ByLevel, Form::Fused] {
        let kinematics = Kinematics::new(&skeleton, form).unwrap();
        let gradient = values(&weighted(&kinematics, &columns).1);
        let start = values(&columns);
        for (number, slope) in gradient.iter().enumerate() {
            let at = |step: f32| {
                let mut moved = start.clone();
                moved[number] += step;
                let moved = Tensor::from_vec(moved, columns.shape(), &Device::Cpu).unwrap();
                let sum = weighted(&kinematics, &moved).0.to_scalar::<f32>().unwrap();
                f64::from(sum)
            };
            let central = (at(STEP) - at(-STEP)) / (2.0 * f64::from(STEP));
            // Rounding of the sum divided by the step, and the third derivative: both below 2e-3.
            assert!(
                (central - f64::from(*slope)).abs() < 4e-3,
                "{form:?} {number}: {central} {slope}"
            );
        }
    }
}
