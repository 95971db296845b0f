//! A figure for tests.

use glam::{DQuat, DVec3};

use super::{BODIES, BODY_COUNT, BodyModel, FigureMotion, Root};
use crate::plant::Mechanism;

/// Returns a figure that stands with its arms down, y up, facing z. Its pelvis and abdomen joints coincide and its
/// hands have no end, as in some real skeletons.
pub fn standing() -> FigureMotion {
    let at = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
    let mut offset_m = vec![DVec3::ZERO; BODY_COUNT];
    let mut segment_end_m = vec![DVec3::ZERO; BODY_COUNT];
    let (thorax, head, hand_l) = (2, 3, 7);
    offset_m[thorax] = at(0.0, 0.2, 0.0);
    offset_m[head] = at(0.0, 0.25, 0.01);
    segment_end_m[head] = at(0.0, 0.24, 0.03);
    for (first, x) in [(4, 1.0), (8, -1.0)] {
        offset_m[first] = at(0.03 * x, 0.2, 0.0);
        offset_m[first + 1] = at(0.15 * x, 0.02, -0.01);
        offset_m[first + 2] = at(0.02 * x, -0.29, 0.0);
        offset_m[first + 3] = at(0.0, -0.26, 0.03);
    }
    for (first, x) in [(12, 1.0), (15, -1.0)] {
        offset_m[first] = at(0.09 * x, -0.08, 0.0);
        offset_m[first + 1] = at(0.01 * x, -0.42, 0.02);
        offset_m[first + 2] = at(0.0, -0.43, -0.01);
        segment_end_m[first + 2] = at(0.01 * x, -0.07, 0.13);
    }
    for body in 1..BODY_COUNT {
        let parent = BODIES[body].parent.unwrap();
        if segment_end_m[parent] == DVec3::ZERO {
            segment_end_m[parent] = offset_m[body];
        }
    }
    assert_eq!(segment_end_m[hand_l], DVec3::ZERO);
    FigureMotion {
        name: "standing".into(),
        dt_s: 0.01,
        offset_m,
        segment_end_m,
        root_position_m: vec![DVec3::ZERO],
        rotation: vec![vec![DQuat::IDENTITY; BODY_COUNT]],
    }
}

/// Returns the standing figure with every joint moving smoothly, each at its own rate below 1 Hz.
pub fn moving(name: &str, frames: u32) -> FigureMotion {
    let still = standing();
    let turn = |frame: u32, body: usize| {
        let (t, k) = (f64::from(frame) * still.dt_s, body as f64);
        let axis = DVec3::new((1.7 * k).sin(), (2.3 * k).cos(), (0.9 * k).sin());
        DQuat::from_scaled_axis(axis * 0.3 * ((2.0 + 0.2 * k) * t + k).sin())
    };
    FigureMotion {
        name: name.to_owned(),
        root_position_m: (0..frames).map(|f| DVec3::new(0.0, 1.0, 0.01 * f64::from(f))).collect(),
        rotation: (0..frames)
            .map(|f| (0..BODY_COUNT).map(|body| turn(f, body)).collect())
            .collect(),
        ..still
    }
}

/// Returns the standing figure as a mechanism.
pub fn mechanism() -> Mechanism {
    BodyModel::from_motion(&standing()).expect("a figure").mechanism(Root::Driven)
}
