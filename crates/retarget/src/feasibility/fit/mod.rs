//! Finds the nearest motion that a rig can perform.
//!
//! It uses three methods, the least intrusive first: a low-pass of single joints, as far as it changes angles only
//! slightly; a slower pace where the motion is too fast or its forces are too large; and poses nearer to home where
//! gravity alone needs too much effort, or a drive becomes too hot. A fit that keeps the time ([`in_time`]) uses other
//! methods instead of the first two.

mod along;
mod course;
mod error;
mod fitting;
mod in_time;
mod interpolation;
mod joint;
mod progress;
mod rest;
mod result;
mod scan;
mod smooth;
mod within;

use sinew_rig::Mechanism;

use super::check::{check, rate_at_rows};
use super::curve::{Curve, Performance as _};
use super::error::CheckError;
use super::limits::Limits;
use super::motion::RigMotion;
use super::report::{Excess, Kind};
pub use error::FitError;
use fitting::{Fitting, Round};
use in_time::Keeping;
use interpolation::interpolated;
pub use progress::Progress;
use rest::Rest;
pub use result::{Fit, FitSettings, LoweredJoint, SmoothedJoint};
use within::Within;

/// Minimum effort limit of a drive, relative to its holding effort at rest: the margin lets it leave the rest pose.
const HOME_AND_MORE: f64 = 1.03;
/// Maximum number of rounds of slowing and lowering: each reduces the remaining excess by a part.
const ROUNDS: usize = 120;
/// Minimum row rate of a fit, Hz: braking and low-passes need a finer time step than a film's frames.
const LEAST_HZ: f64 = 100.0;

/// Finds the nearest motion within all limits. O(rows · bodies) for each of at most 120 rounds, usually ten.
///
/// A motion that keeps the margins of `settings` to all limits is returned unchanged; for any other, the rows may be
/// finer than given.
///
/// # Errors
/// [`FitError`] if the motion is invalid for the rig, no pose near its home is light enough, or a limit remains
/// exceeded.
pub fn fit(
    mechanism: &Mechanism,
    limits: &Limits,
    motion: &RigMotion,
    settings: FitSettings,
) -> Result<Fit, FitError> {
    go_on(mechanism, limits, motion, None, settings)
}

/// Performs [`fit`](fit()) of the same motion to tighter limits. It continues from an earlier fit, which takes a
/// fraction of the time, and needs only its [`Fit::progress`].
///
/// # Errors
/// Those of [`fit`](fit()).
pub fn refit(
    mechanism: &Mechanism,
    limits: &Limits,
    motion: &RigMotion,
    before: &Progress,
    settings: FitSettings,
) -> Result<Fit, FitError> {
    go_on(mechanism, limits, motion, Some(before), settings)
        // The earlier changes may prevent a result, therefore a fit from the start is tried.
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
    let before = before.filter(|before| before.is_of(motion, settings.keep_time));
    if settings.keep_time {
        let mut keeping = Keeping::new(mechanism, &kept, &rest, motion, settings)?;
        if let Some(before) = before {
            keeping.go_on_from(before);
        }
        drop(finer);
        for _ in 0..ROUNDS {
            match keeping.round()? {
                Round::Within => return Ok(keeping.done()),
                Round::Nearer => {}
                Round::Hopeless => break,
            }
        }
        let curve = keeping.curve();
        return match remaining(mechanism, limits, &rest, &curve, None, settings)? {
            None => Ok(keeping.done()),
            Some(why) => Err(why),
        };
    }
    let mut fitting = Fitting::new(mechanism, &kept, &rest, motion, settings)?;
    if let Some(before) = before {
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
    let (curve, given_s) = fitting.curve();
    match remaining(mechanism, limits, &rest, &curve, Some(&given_s), settings)? {
        None => Ok(fitting.done()),
        Some(why) => Err(why),
    }
}

/// Returns the reason why a motion cannot be performed; `None` if it keeps the limits without their margin. `given_s`:
/// time of each row in the given motion, s; `None` if the motion's own times are meant.
fn remaining(
    mechanism: &Mechanism,
    limits: &Limits,
    rest: &Rest,
    curve: &Curve,
    given_s: Option<&[f64]>,
    settings: FitSettings,
) -> Result<Option<FitError>, CheckError> {
    let report = check(mechanism, limits, curve, settings.rate_hz)?;
    let beyond = |excess: &&Excess| (excess.value / excess.limit - 1.0).abs();
    let worst = report.excesses.iter().max_by(|a, b| beyond(a).total_cmp(&beyond(b)));
    Ok(worst.map(|excess| {
        let dof = &limits.dofs[excess.dof];
        let (joint, slides) = (dof.name.clone(), dof.slides);
        let Excess { kind, value, limit, worst_s, .. } = *excess;
        let time_s = given_s.map_or(worst_s, |given_s| {
            let rows_a_s = (given_s.len() - 1) as f64 / curve.duration_s();
            interpolated(given_s, worst_s * rows_a_s)
        });
        let held = rest.holding[excess.dof].abs();
        let in_time = settings.keep_time;
        if kind == Kind::Effort && held > limit {
            FitError::Heavy { joint, slides, held, limit }
        } else {
            FitError::OutOfReach { joint, slides, kind, value, limit, time_s, in_time }
        }
    }))
}

/// Returns the limits with a margin for the rounding of a show, except efforts that the rest pose needs almost
/// entirely.
fn kept(limits: &Limits, holding: &[f64], share: f64) -> Limits {
    let mut kept = limits.at(share);
    for ((kept, limits), held) in kept.dofs.iter_mut().zip(&limits.dofs).zip(holding) {
        kept.effort = kept.effort.max(HOME_AND_MORE * held.abs()).min(limits.effort);
    }
    kept
}
