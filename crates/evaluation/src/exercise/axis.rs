//! An axis of a joint: where it may go, and how fast.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use glam::DQuat;
use sinew_rig::mechanism::{JointModel, Link};

use super::error::ExerciseError;

/// Slower than any servo: the speed of an axis that has no limit, rad/s and m/s.
pub(super) const SPEED: [f64; 2] = [2.0, 0.5];
/// The acceleration of an axis that has no limit, rad/s² and m/s².
pub(super) const ACCELERATION: [f64; 2] = [20.0, 5.0];
/// How far an axis without range goes to both sides of its home, rad and m.
const REACH: [f64; 2] = [FRAC_PI_2, 0.1];
/// How far a ball joint without range goes, rad.
const BALL_RAD: f64 = FRAC_PI_3;
/// Share of a range that is kept free at both ends.
const MARGIN: f64 = 0.05;

/// An axis of a joint: where it may go, and how fast.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub(super) home: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Axis {
    /// The axes of a joint.
    pub(super) fn of_joint(link: &Link) -> Result<Vec<Self>, ExerciseError> {
        let expected = link.joint.kind().coordinate_count();
        if link.home.len() != expected || !link.home.iter().all(|at| at.is_finite()) {
            let (joint, found) = (link.joint_name.clone(), link.home.clone());
            return Err(ExerciseError::Home { joint, expected, found });
        }
        let slides = usize::from(matches!(link.joint, JointModel::Prismatic(_)));
        let limit = |limit: f64, without: f64| if limit.is_finite() { limit } else { without };
        let axis = |home: f64, range: [f64; 2]| {
            let [least, most] = range;
            let margin = MARGIN * (most - least);
            Self {
                home: home.clamp(least, most),
                least: least + margin,
                most: most - margin,
                speed: limit(link.speed, SPEED[slides]),
                acceleration: limit(link.acceleration, ACCELERATION[slides]),
            }
        };
        Ok(match link.joint {
            JointModel::Fixed | JointModel::Free => Vec::new(),
            JointModel::Spherical => {
                let most = link.ranges.first().map_or(BALL_RAD, |range| range[1].min(BALL_RAD));
                // The corners of the cube that they go through are within the range; so is their speed together.
                let most = most / f64::sqrt(3.0);
                let &[x, y, z, w] = link.home.as_slice() else { return Ok(Vec::new()) };
                let q = DQuat::from_xyzw(x, y, z, w).normalize();
                let home = if q.w < 0.0 { -q } else { q }.to_scaled_axis().to_array();
                let shared = |axis: Self| Self {
                    speed: axis.speed / f64::sqrt(3.0),
                    acceleration: axis.acceleration / f64::sqrt(3.0),
                    ..axis
                };
                home.map(|home| shared(axis(home, [-most, most]))).to_vec()
            }
            _ => {
                let reach = REACH[slides];
                let range = |index: usize, home: f64| {
                    let [least, most] = link
                        .ranges
                        .get(index)
                        .copied()
                        .unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
                    // Where there is no limit, as far as from home.
                    let least = if least.is_finite() { least } else { home.min(most) - reach };
                    let most = if most.is_finite() { most } else { home.max(least) + reach };
                    [least, most]
                };
                let homes = link.home.iter().enumerate();
                homes.map(|(index, home)| axis(*home, range(index, *home))).collect()
            }
        })
    }

    /// The same within two ends, or still at home if there is nothing between them.
    pub(super) fn within(self, least: f64, most: f64) -> Self {
        let (least, most) =
            (self.least.max(least).min(self.home), self.most.min(most).max(self.home));
        Self { least, most, ..self }
    }

    /// Time from one place to another at a share of what the axis can, s.
    pub(super) fn duration_s(&self, way: f64, share: f64) -> f64 {
        // The largest speed and acceleration of minimum jerk over a way of 1 in 1 s.
        const SPEED: f64 = 1.875;
        // 10 / √3.
        const ACCELERATION: f64 = 5.773_502_691_896_258;
        let way = way.abs();
        (SPEED * way / (share * self.speed))
            .max(f64::sqrt(ACCELERATION * way / (share * self.acceleration)))
    }
}
