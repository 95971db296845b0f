//! The path along which a scripted hand leads a rig.

use std::f64::consts::{PI, TAU};

use sinew_retarget::feasibility::{Curve, Instant, MotionError, Performance as _, RigMotion};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

/// Rest before and after the built-in motion, s.
const REST_S: f64 = 1.0;
/// Duration of the built-in motion, s.
const WAY_S: f64 = 6.0;
/// Largest deflection of a joint: the smaller of a share of its range, and an angle or a distance in rad or m.
const FAR: (f64, f64) = (0.15, 0.6);
/// Rows per second of the built-in path.
const RATE_HZ: f64 = 50.0;

/// A path through poses of a rig.
#[derive(Debug, Clone)]
pub struct GuideTrajectory(Curve);

impl GuideTrajectory {
    /// Creates a path along a motion.
    ///
    /// # Errors
    /// [`MotionError`] if it is not a motion of the rig.
    pub fn along(mechanism: &Mechanism, motion: &RigMotion) -> Result<Self, MotionError> {
        Curve::new(mechanism, motion).map(Self)
    }

    /// Creates the built-in path from home and back, 8 s: all joints at once, each to both sides; ball joints stay.
    ///
    /// # Errors
    /// [`MotionError`] if the rig's coordinates are invalid.
    pub fn built_in(mechanism: &Mechanism) -> Result<Self, MotionError> {
        let home = mechanism.home();
        let ranges = mechanism.coordinate_ranges();
        let row = |time_s: f64| {
            let mut q = home.clone();
            let share = ((time_s - REST_S) / WAY_S).clamp(0.0, 1.0);
            // Speed and acceleration are zero at both ends.
            let swing = libm::pow(libm::sin(PI * share), 3.0);
            let joints = mechanism.bodies.iter().zip(&ranges);
            for (index, (link, range)) in joints.enumerate() {
                if matches!(
                    link.joint,
                    JointModel::Free | JointModel::Spherical | JointModel::Fixed
                ) {
                    continue;
                }
                for (place, ends) in range.clone().zip(&link.ranges) {
                    let [least, most] = *ends;
                    let (part, far) = FAR;
                    // A joint without limits uses the largest absolute deflection.
                    let reach = (part * (most - least)).min(far);
                    let middle = home[place].clamp(least + reach, most - reach);
                    let phase = index as f64;
                    let way = (middle - home[place]) + reach * libm::sin(TAU * share + phase);
                    q[place] += swing * way;
                }
            }
            q
        };
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "400")]
        let count = ((WAY_S + 2.0 * REST_S) * RATE_HZ) as usize;
        let dt_s = RATE_HZ.recip();
        let rows = (0..=count).map(|index| row(index as f64 * dt_s)).collect();
        Self::along(mechanism, &RigMotion { dt_s, rows })
    }

    /// Returns the duration, s.
    pub fn duration_s(&self) -> f64 {
        self.0.duration_s()
    }

    /// Returns position and velocity at a time.
    pub fn at(&self, time_s: f64) -> Instant {
        let mut instant = Instant::default();
        self.0.at(time_s, &mut instant);
        instant
    }
}
