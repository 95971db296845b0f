//! Settings of a fit, and its result.

use super::interpolation::interpolated;
use super::progress::Progress;
use crate::feasibility::motion::RigMotion;

/// Permitted changes of a fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitSettings {
    /// Maximum change by a low-pass, rad or m.
    pub change: f64,
    /// Share of all limits of speed, acceleration and effort that the fit observes.
    pub share: f64,
    /// Distance of joints from the ends of their ranges, rad or m: a margin for the rounding of a show.
    pub room: f64,
    /// Minimum sampling rate of the checks, Hz. Every row is sampled, because a curve's accelerations are largest
    /// there, and places evenly between rows, where it may leave a range.
    pub rate_hz: f64,
    /// Whether the motion keeps its time: where it exceeds a limit, it becomes smaller or smoother, but not slower.
    pub keep_time: bool,
    /// Whether a motion that keeps its time begins at rest, if the fit changes it. A controller starts a show that
    /// begins at speed more slowly, and the show stays late.
    pub from_rest: bool,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self {
            change: 0.05,
            share: 0.95,
            room: 0.005,
            rate_hz: 200.0,
            keep_time: false,
            from_rest: false,
        }
    }
}

/// A motion within all limits, with the changes made for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The new motion.
    pub motion: RigMotion,
    /// Time in the given motion of every row of the new motion, s; used to shift cues.
    pub given_s: Vec<f64>,
    /// Settings with which the motion was fitted.
    pub settings: FitSettings,
    /// Joints whose angles were low-passed.
    pub smoothed: Vec<SmoothedJoint>,
    /// Minimum share of the given speed, and its time in the given motion, s.
    pub slowest: (f64, f64),
    /// Joints that were drawn towards home.
    pub lowered: Vec<LoweredJoint>,
    /// If home itself needs too much effort: joints of the lighter pose that replaces it, and their distances from
    /// home, rad or m.
    pub lightened: Vec<(String, f64)>,
    /// Joints that were limited to their range, with the largest change, rad or m.
    pub clamped: Vec<(String, f64)>,
    /// Changes so far, from which [`refit`](super::refit) continues.
    pub progress: Progress,
}

/// A low-passed joint.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothedJoint {
    /// Name of the joint.
    pub joint: String,
    /// Standard deviation of the low-pass, s.
    pub width_s: f64,
    /// Largest change by the low-pass, rad or m.
    pub change: f64,
}

/// A joint that was drawn towards home.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredJoint {
    /// Name of the joint.
    pub joint: String,
    /// Smallest remaining share of the joint's distance from home.
    pub share: f64,
    /// Time of that share in the given motion, s.
    pub at_s: f64,
}

impl Fit {
    /// Returns the changes, and drops the motion, which may be long.
    #[must_use]
    pub fn into_progress(self) -> Progress {
        self.progress
    }

    /// Converts a time of the new motion to the time in the given motion, s.
    pub fn given_time_s(&self, time_s: f64) -> f64 {
        interpolated(&self.given_s, time_s / self.motion.dt_s)
    }
}
