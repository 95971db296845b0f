use glam::{DMat3, DQuat, EulerRot};

use super::*;
use crate::fixture::standing;

/// Builds both body models on one skeleton.
fn both(motion: &FigureMotion) -> [BodyModel; 2] {
    [
        BodyModel::from_motion(motion).unwrap(),
        BodyModel::hanavan_kwon(motion, Subject::built_in()).unwrap(),
    ]
}

#[test]
fn masses_sum_to_the_whole_and_scale_with_the_volume() {
    let model = BodyModel::from_motion(&standing()).unwrap();
    assert!((model.mass_kg() - 73.0).abs() < 1e-12);
    let larger = model.scaled(1.1);
    assert!((larger.mass_kg() - 73.0 * 1.331).abs() < 1e-9);
    let ratio =
        larger.bodies[5].rotational_kg_m2.z_axis.z / model.bodies[5].rotational_kg_m2.z_axis.z;
    assert!((ratio - 1.1f64.powi(5)).abs() < 1e-12);
}

#[test]
fn every_inertia_is_one_that_a_body_can_have() {
    for model in both(&standing()) {
        for scale in [0.1, 1.0, 1.1, 10.0] {
            // The tree refuses impossible inertias in f32; this test checks them in f64, with a margin.
            model.scaled(scale).mechanism(Root::Driven).tree::<18>().unwrap();
        }
        for (place, body) in BODIES.iter().zip(&model.bodies) {
            let matrix: nalgebra::Matrix3<f64> =
                nalgebra::Matrix3::from_fn(|r, c| body.rotational_kg_m2.col(c)[r]);
            let moments = matrix.symmetric_eigenvalues();
            let possible = moments.min() > 0.0 && 2.0 * moments.max() < moments.sum();
            assert!(possible, "{}: {moments}", place.name);
        }
    }
}

#[test]
fn left_and_right_are_mirror_images() {
    let mirror = DMat3::from_diagonal(DVec3::new(-1.0, 1.0, 1.0));
    for model in both(&standing()) {
        for (left, right) in
            [4, 5, 6, 7].into_iter().zip([8, 9, 10, 11]).chain([(12, 15), (13, 16), (14, 17)])
        {
            let (l, r) = (&model.bodies[left], &model.bodies[right]);
            assert!((l.mass_kg - r.mass_kg).abs() < 1e-15);
            assert!((mirror * l.center_of_mass_m - r.center_of_mass_m).length() < 1e-15);
            let difference = mirror * l.rotational_kg_m2 * mirror - r.rotational_kg_m2;
            assert!(difference.abs_diff_eq(DMat3::ZERO, 1e-15), "{}", BODIES[left].name);
        }
    }
}

/// Checks that a body has the same inertia, only rotated, in a skeleton whose frames have other orientations.
#[test]
fn the_body_does_not_depend_on_how_frames_lie() {
    let straight = standing();
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.4, -1.0, 2.0);
    let turned = FigureMotion {
        offset_m: straight.offset_m.iter().map(|v| turn * *v).collect(),
        segment_end_m: straight.segment_end_m.iter().map(|v| turn * *v).collect(),
        ..straight.clone()
    };
    let matrix = DMat3::from_quat(turn);
    for (a, b) in both(&straight).iter().zip(&both(&turned)) {
        for (a, b) in a.bodies.iter().zip(&b.bodies) {
            assert!((turn * a.center_of_mass_m - b.center_of_mass_m).length() < 1e-14);
            let expected = matrix * a.rotational_kg_m2 * matrix.transpose();
            assert!(expected.abs_diff_eq(b.rotational_kg_m2, 1e-14));
        }
    }
}

#[test]
fn impossible_skeletons_are_refused() {
    let mut no_shank = standing();
    no_shank.segment_end_m[13] = DVec3::ZERO;
    assert_eq!(BodyModel::from_motion(&no_shank), Err(BodyModelError::NoLength("shank_l")));
    let mut no_hips = standing();
    no_hips.offset_m[12] = no_hips.offset_m[15];
    assert_eq!(BodyModel::from_motion(&no_hips), Err(BodyModelError::NoOrientation));
    let mut nan = standing();
    nan.offset_m[3].y = f64::NAN;
    assert_eq!(BodyModel::from_motion(&nan), Err(BodyModelError::NonFinite("head")));
}
