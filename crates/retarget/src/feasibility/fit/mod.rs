//! The nearest motion that a rig can perform.
//!
//! Three means, the one that changes least first: a low-pass of single joints where that changes no angle by more than
//! a little; a slower course where the motion is too fast or its forces are too large; and poses nearer to home where
//! gravity alone asks for too much, or a drive becomes too hot.

mod along;
mod course;
mod fitting;
mod joint;
mod rest;
mod scan;
mod smooth;
mod within;

use sinew_rig::Mechanism;
use thiserror::Error;

use super::check::{CheckError, Excess, Kind, check, rate_at_rows};
use super::curve::{Curve, Performance as _};
use super::limits::Limits;
use super::motion::{MotionError, RigMotion};
pub use fitting::Progress;
use fitting::{Fitting, Round};
use rest::Rest;
use within::Within;

/// What a drive has, beside what holds the rig at rest, to leave it.
const HOME_AND_MORE: f64 = 1.03;
/// Rounds of slowing and lowering: each brings what is left of an excess down by a part.
const ROUNDS: usize = 120;
/// Rows a second that a fit works on at least: braking and low-passes are finer than a film's frames.
const LEAST_HZ: f64 = 100.0;

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
    pub smoothed: Vec<Smoothed>,
    /// The slowest course: share of the given speed, and when in the given motion, s.
    pub slowest: (f64, f64),
    /// Joints that were drawn towards home.
    pub lowered: Vec<Lowered>,
    /// Where home itself is too heavy: joints of the lighter pose that is drawn towards instead, and how far from home
    /// they are, rad or m.
    pub lightened: Vec<(String, f64)>,
    /// The most that any angle or way was brought back into its range, by joint; only those that were.
    pub clamped: Vec<(String, f64)>,
    /// What was done, for [`refit`].
    pub progress: Progress,
}

/// A low-passed joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothed {
    /// The joint.
    pub joint: String,
    /// Standard deviation of the low-pass, s.
    pub width_s: f64,
    /// The most that it changed, rad or m.
    pub change: f64,
}

/// A joint that was drawn towards home.
#[derive(Debug, Clone, PartialEq)]
pub struct Lowered {
    /// The joint.
    pub joint: String,
    /// The least share of its way from home that is left.
    pub share: f64,
    /// When, in the given motion, s.
    pub at_s: f64,
}

/// Why there is no fit.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FitError {
    /// The motion is none of the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The rig or an instant was refused.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// No pose near home is light enough to draw the motion towards it.
    #[error(
        "`{joint}`: the home pose, and every pose found near it, takes {} or more of its limit {}: give the rig a lighter home \
         pose, or a stronger drive",
        Kind::Effort.shown(*slides, *held),
        Kind::Effort.shown(*slides, *limit)
    )]
    Heavy {
        /// The dof.
        joint: String,
        /// Whether it slides.
        slides: bool,
        /// What holds it in the lightest pose, N m or N.
        held: f64,
        /// The limit.
        limit: f64,
    },
    /// Nothing helps.
    #[error(
        "`{joint}`: its {} is {} and its limit is {}, at {time_s:.2} s of what was given: slower, smoother and nearer to home \
         it is still beyond, or too near to its limit for what a show rounds",
        kind.name(),
        kind.shown(*slides, *value),
        kind.shown(*slides, *limit)
    )]
    OutOfReach {
        /// The dof.
        joint: String,
        /// Whether it slides.
        slides: bool,
        /// Of what.
        kind: Kind,
        /// What it would be.
        value: f64,
        /// The limit.
        limit: f64,
        /// When in the given motion, s.
        time_s: f64,
    },
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

/// Between evenly spaced values; the first and the last go on beyond the ends.
fn interpolated(values: &[f64], place: f64) -> f64 {
    let last = values.len().saturating_sub(1);
    let place = place.clamp(0.0, last as f64);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "within the values"
    )]
    let index = place.floor() as usize;
    let [from, to] =
        [index, (index + 1).min(last)].map(|index| values.get(index).copied().unwrap_or(0.0));
    from + (place - index as f64) * (to - from)
}

/// Finds the nearest motion within all limits. O(rows · bodies) for each of at most 120 rounds, usually ten.
///
/// A motion that exceeds nothing is returned as it is; of any other the rows may be finer than those given.
///
/// # Errors
/// [`FitError`] if the motion is none of the rig, or no pose near its home is light enough.
pub fn fit(
    mechanism: &Mechanism,
    limits: &Limits,
    motion: &RigMotion,
    settings: FitSettings,
) -> Result<Fit, FitError> {
    go_on(mechanism, limits, motion, None, settings)
}

/// [`fit`](fit()) of the same motion to limits that are tighter than those of a fit before: it goes on from there, in a
/// part of the time. Of that fit it needs no more than its [`Fit::progress`].
///
/// # Errors
/// As [`fit`](fit()).
pub fn refit(
    mechanism: &Mechanism,
    limits: &Limits,
    motion: &RigMotion,
    before: &Progress,
    settings: FitSettings,
) -> Result<Fit, FitError> {
    go_on(mechanism, limits, motion, Some(before), settings)
        // What was done before may be in the way.
        .or_else(|_| go_on(mechanism, limits, motion, None, settings))
}

fn go_on(
    mechanism: &Mechanism,
    limits: &Limits,
    motion: &RigMotion,
    before: Option<&Progress>,
    settings: FitSettings,
) -> Result<Fit, FitError> {
    let rest = Rest::of(mechanism, limits, &mut Within::new(mechanism, settings.room))?;
    let kept = kept(limits, &rest.holding, settings.share);
    let curve = Curve::new(mechanism, motion)?;
    let finer = (LEAST_HZ * motion.dt_s).ceil();
    let is_coarse = finer > 1.0
        && !check(mechanism, &kept, &curve, rate_at_rows(settings.rate_hz, motion.dt_s))?
            .excesses
            .is_empty();
    let finer = is_coarse.then(|| curve.resampled(finer / motion.dt_s));
    drop(curve);
    let motion = finer.as_ref().unwrap_or(motion);
    let rate_hz = rate_at_rows(settings.rate_hz, motion.dt_s);
    let settings = FitSettings { rate_hz, ..settings };
    let mut fitting = Fitting::new(mechanism, &kept, &rest, motion, settings)?;
    if let Some(before) = before.filter(|before| before.is_of(motion)) {
        fitting.go_on_from(before);
    }
    drop(finer);
    if fitting.smooth()? {
        return Ok(fitting.done());
    }
    for _ in 0..ROUNDS {
        match fitting.round()? {
            Round::Within => return Ok(fitting.done()),
            Round::Nearer => {}
            Round::Hopeless => break,
        }
    }
    // What is left may be within the limits themselves.
    let (curve, given_s) = fitting.curve();
    let report = check(mechanism, limits, &curve, settings.rate_hz)?;
    let beyond = |excess: &&Excess| (excess.value / excess.limit - 1.0).abs();
    match report.excesses.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b))) {
        None => Ok(fitting.done()),
        Some(excess) => {
            let dof = &limits.dofs[excess.dof];
            let (joint, slides) = (dof.name.clone(), dof.slides);
            let Excess { kind, value, limit, worst_s, .. } = *excess;
            let rows_a_s = (given_s.len() - 1) as f64 / curve.duration_s();
            let time_s = interpolated(&given_s, worst_s * rows_a_s);
            let held = rest.holding[excess.dof].abs();
            Err(if kind == Kind::Effort && held > limit {
                FitError::Heavy { joint, slides, held, limit }
            } else {
                FitError::OutOfReach { joint, slides, kind, value, limit, time_s }
            })
        }
    }
}

/// The limits with room for what a show rounds, but for torques that the pose at rest takes nearly all of.
fn kept(limits: &Limits, holding: &[f64], share: f64) -> Limits {
    let mut kept = limits.at(share);
    for ((kept, limits), held) in kept.dofs.iter_mut().zip(&limits.dofs).zip(holding) {
        kept.effort = kept.effort.max(HOME_AND_MORE * held.abs()).min(limits.effort);
    }
    kept
}
