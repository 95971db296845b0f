//! The settings of a fit, and its result.

use super::interpolation::interpolated;
use super::progress::Progress;
use crate::feasibility::motion::RigMotion;

/// How far a fit may go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FitSettings {
    /// The most that a low-pass may change an angle, rad, or a way, m.
    pub change: f64,
    /// Share of all limits of speed, acceleration and effort that the fit keeps to.
    pub share: f64,
    /// How far from the ends of their ranges joints stay, rad or m: room for what a show rounds.
    pub room: f64,
    /// How often a second the motion is looked at, at least: at every row, where a curve's accelerations are largest,
    /// and evenly between, where it may swing out of a range.
    pub rate_hz: f64,
}

impl Default for FitSettings {
    fn default() -> Self {
        Self { change: 0.05, share: 0.95, room: 0.005, rate_hz: 200.0 }
    }
}

/// A motion within all limits, and what was done for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// The motion.
    pub motion: RigMotion,
    /// Time in the given motion of every row of the new one, s: cues follow.
    pub given_s: Vec<f64>,
    /// Joints whose angles were low-passed.
    pub smoothed: Vec<SmoothedJoint>,
    /// The slowest course: share of the given speed, and when in the given motion, s.
    pub slowest: (f64, f64),
    /// Joints that were drawn towards home.
    pub lowered: Vec<LoweredJoint>,
    /// Where home itself is too heavy: joints of the lighter pose that is drawn towards instead, and how far from home
    /// they are, rad or m.
    pub lightened: Vec<(String, f64)>,
    /// The most that any angle or way was brought back into its range, by joint; only those that were.
    pub clamped: Vec<(String, f64)>,
    /// The changes so far, from which [`refit`](super::refit) goes on.
    pub progress: Progress,
}

/// A low-passed joint.
#[derive(Debug, Clone, PartialEq)]
pub struct SmoothedJoint {
    /// The joint.
    pub joint: String,
    /// Standard deviation of the low-pass, s.
    pub width_s: f64,
    /// The most that it changed, rad or m.
    pub change: f64,
}

/// A joint that was drawn towards home.
#[derive(Debug, Clone, PartialEq)]
pub struct LoweredJoint {
    /// The joint.
    pub joint: String,
    /// The least share of its way from home that is left.
    pub share: f64,
    /// When, in the given motion, s.
    pub at_s: f64,
}

impl Fit {
    /// What was done; the motion, which may be long, is dropped.
    #[must_use]
    pub fn into_progress(self) -> Progress {
        self.progress
    }

    /// The time in the given motion, s, at a time of the new one.
    pub fn given_time_s(&self, time_s: f64) -> f64 {
        interpolated(&self.given_s, time_s / self.motion.dt_s)
    }
}
