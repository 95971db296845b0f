//! An axis of a joint: its range, speed and acceleration.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_3};

use glam::DQuat;
use sinew_rig::mechanism::{JointModel, Link};

use super::error::ExerciseError;

/// Speeds of an axis without a speed limit, rad/s and m/s. They are lower than those of any servo.
pub(super) const SPEED: [f64; 2] = [2.0, 0.5];
/// Accelerations of an axis without an acceleration limit, rad/s² and m/s².
pub(super) const ACCELERATION: [f64; 2] = [20.0, 5.0];
/// Maximum distance of an axis without a range from its home, to each side, rad and m.
const REACH: [f64; 2] = [FRAC_PI_2, 0.1];
/// Range of a ball joint without a range, rad.
const BALL_RAD: f64 = FRAC_PI_3;
/// Share of a range that is left unused at each end.
const MARGIN: f64 = 0.05;

/// An axis of a joint: its range, speed and acceleration.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub(super) home: f64,
    pub(super) least: f64,
    pub(super) most: f64,
    pub(super) speed: f64,
    pub(super) acceleration: f64,
}

impl Axis {
    /// Returns the axes of a joint.
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
                // The three components span a cube whose corners are within the range. Their combined speed is
                // within the limit too.
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
                    // A missing limit is replaced by the reach from home.
                    let least = if least.is_finite() { least } else { home.min(most) - reach };
                    let most = if most.is_finite() { most } else { home.max(least) + reach };
                    [least, most]
                };
                let homes = link.home.iter().enumerate();
                homes.map(|(index, home)| axis(*home, range(index, *home))).collect()
            }
        })
    }

    /// Returns the axis with its range reduced to the part from `least` to `most`. Home always remains in the range.
    pub(super) fn within(self, least: f64, most: f64) -> Self {
        let (least, most) =
            (self.least.max(least).min(self.home), self.most.min(most).max(self.home));
        Self { least, most, ..self }
    }

    /// Returns the time for a distance at a share of the axis's maximum speed and acceleration, s.
    pub(super) fn duration_s(&self, way: f64, share: f64) -> f64 {
        // Maximum speed of a motion of minimum jerk over a distance of 1 in 1 s.
        const SPEED: f64 = 1.875;
        // Maximum acceleration of that motion: 10 / √3.
        const ACCELERATION: f64 = 5.773_502_691_896_258;
        let way = way.abs();
        (SPEED * way / (share * self.speed))
            .max(f64::sqrt(ACCELERATION * way / (share * self.acceleration)))
    }
}
