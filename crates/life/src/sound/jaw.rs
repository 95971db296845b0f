//! The angle of a jaw, within its limits of speed and acceleration.

use std::fmt::Write as _;

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

use super::RATE_HZ;
use crate::limit::within;

/// Distance of a closed jaw from its home, towards open, rad: 0.3 deg. The error of a show is smaller, so the jaw stays
/// in its range even if home is an end of it.
const MARGIN_RAD: f64 = 0.3 * std::f64::consts::PI / 180.0;
/// Share of the way from home to the end of the range at which a jaw is fully open.
const OPEN_SHARE: f64 = 0.8;
/// Smallest share of the opening that is still accepted as a motion.
const LEAST: f64 = 0.05;

/// A jaw: its joint, angles and limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Jaw {
    /// Name of the joint.
    pub joint: String,
    /// Angle of the closed jaw, rad.
    pub closed_rad: f64,
    /// Angle of the open jaw, rad.
    pub open_rad: f64,
    /// Maximum speed, rad/s; infinite without a limit.
    pub speed: f64,
    /// Maximum acceleration, rad/s²; infinite without a limit.
    pub acceleration: f64,
    /// Range, rad; infinite without a limit.
    pub range_rad: [f64; 2],
}

/// The motion of a jaw.
#[derive(Debug, Clone, PartialEq)]
pub struct JawMotion {
    /// Angles at [`RATE_HZ`], rad.
    pub angles_rad: Vec<f64>,
    /// Width of the smoothing that was needed for the limits of the jaw, s; 0 without smoothing.
    pub smoothed_s: f64,
    /// Largest speed of the motion, rad/s.
    pub fastest: f64,
    /// Share of the full opening that remains after the motion was made smaller for the limits; 1: the full opening.
    pub share: f64,
}

/// The reason why a jaw cannot follow an opening.
#[derive(Debug, Error)]
pub enum JawError {
    /// The rig has no such joint that turns about one axis.
    #[error(
        "the rig has no joint `{found}` that turns about one axis: expected one of {expected}; `--joint` names it"
    )]
    NoJoint {
        /// Name of the joint.
        found: String,
        /// Names of all joints that turn about one axis.
        expected: String,
    },
    /// The closed or the open angle is outside the joint's range.
    #[error(
        "joint `{joint}`: {found_deg:.1} deg is not within its range, {from_deg:.1} to {to_deg:.1} deg"
    )]
    Range {
        /// Name of the joint.
        joint: String,
        /// The angle, deg.
        found_deg: f64,
        /// Lower end of the range, deg.
        from_deg: f64,
        /// Upper end of the range, deg.
        to_deg: f64,
    },
    /// The joint is too slow: its limits leave less than 5 % of the way.
    #[error(
        "joint `{joint}` is too slow: of the way from closed to open its speed and acceleration leave {percent:.1} %"
    )]
    TooSlow {
        /// Name of the joint.
        joint: String,
        /// Share of the way that remains, in percent.
        percent: f64,
    },
}

impl Jaw {
    /// Creates a jaw without a rig and without limits.
    pub fn free(joint: &str, closed_rad: f64, open_rad: f64) -> Self {
        let range_rad = [f64::NEG_INFINITY, f64::INFINITY];
        let (speed, acceleration) = (f64::INFINITY, f64::INFINITY);
        Self { joint: joint.to_owned(), closed_rad, open_rad, speed, acceleration, range_rad }
    }

    /// Creates the jaw of a rig. It is closed at home (0.3 deg towards open), and open at four fifths of the way to the
    /// farther end of its range, or at 20 deg from home if that end is infinite.
    ///
    /// # Errors
    /// [`JawError::NoJoint`] if the rig has no such joint that turns about one axis.
    pub fn of(mechanism: &Mechanism, joint: &str) -> Result<Self, JawError> {
        let hinges =
            || mechanism.bodies.iter().filter(|link| matches!(link.joint, JointModel::Revolute(_)));
        let link = hinges().find(|link| link.joint_name == joint).ok_or_else(|| {
            let names: Vec<&str> = hinges().map(|link| link.joint_name.as_str()).collect();
            JawError::NoJoint { found: joint.to_owned(), expected: names.join(", ") }
        })?;
        let home = link.home.first().copied().unwrap_or_default();
        let range_rad = link.ranges.first().copied();
        let range_rad = range_rad.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
        let [least, most] = range_rad.map(|end| end - home);
        let far = if -least > most { least } else { most };
        let way = if far.is_finite() { OPEN_SHARE * far } else { 20_f64.to_radians() };
        Ok(Self {
            joint: joint.to_owned(),
            closed_rad: home + MARGIN_RAD.min(0.1 * way.abs()).copysign(way),
            open_rad: home + way,
            speed: link.speed,
            acceleration: link.acceleration,
            range_rad,
        })
    }

    /// Converts an opening, 0 to 1, to angles. If the jaw's speed or acceleration is too small, the motion is smoothed
    /// over at most 120 ms, and then made smaller. The smoothing is symmetric, so it causes no delay.
    ///
    /// # Errors
    /// [`JawError`] if the closed or the open angle is outside the range, or the joint is too slow.
    pub fn follow(&self, opening: &[f64]) -> Result<JawMotion, JawError> {
        let [from_deg, to_deg] = self.range_rad.map(f64::to_degrees);
        for angle in [self.closed_rad, self.open_rad] {
            if !(self.range_rad[0] - 1e-9..=self.range_rad[1] + 1e-9).contains(&angle) {
                let (joint, found_deg) = (self.joint.clone(), angle.to_degrees());
                return Err(JawError::Range { joint, found_deg, from_deg, to_deg });
            }
        }
        let way = self.open_rad - self.closed_rad;
        let ways: Vec<f64> = opening.iter().map(|open| open * way.abs()).collect();
        // The CSV contains every second row.
        let limited = within(&ways, RATE_HZ, 2, [self.speed, self.acceleration]);
        if limited.share < LEAST {
            return Err(JawError::TooSlow {
                joint: self.joint.clone(),
                percent: 100.0 * limited.share,
            });
        }
        let angle = |open: &f64| self.closed_rad + open.clamp(0.0, way.abs()).copysign(way);
        Ok(JawMotion {
            angles_rad: limited.values.iter().map(angle).collect(),
            smoothed_s: limited.smoothed_s,
            fastest: limited.fastest,
            share: limited.share,
        })
    }

    /// Returns the motion as a CSV of keys for `sinew bake`, at half of [`RATE_HZ`].
    pub fn csv(&self, motion: &JawMotion) -> String {
        let mut text = format!("time,{}_deg\n", self.joint);
        for (row, angle) in motion.angles_rad.iter().enumerate().step_by(2) {
            let time_s = row as f64 / RATE_HZ;
            writeln!(text, "{time_s:.3},{:.4}", angle.to_degrees() + 0.0)
                .expect("a string takes everything");
        }
        text
    }
}
