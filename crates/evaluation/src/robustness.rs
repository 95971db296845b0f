//! What a real rig does to a setup: masses that nobody knows, sensors in steps, drives that come late.

use rayon::prelude::*;
use sinew_core::tracker::MethodName;

use super::capacity::MAX_LATENCY_STEPS;
use super::controller::narrow;
use super::error::RunError;
use super::metrics::Errors;
use super::motion::EvaluatedMotion;
use super::run::Run;
use super::setup::Setup;

/// The errors of one setup over all clips, or the clip that the figure was lost on.
pub type Trial = Result<Errors, Lost>;

/// A figure that was lost.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{clip}: {kind}")]
pub struct Lost {
    /// The clip.
    pub clip: String,
    /// How.
    pub kind: RunError,
}

/// Tracks all clips with one setup, in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// [`Lost`]: the first clip, in their order, that the figure was lost on.
pub fn trial(motions: &[impl EvaluatedMotion], setup: &Setup, seconds: Option<f64>) -> Trial {
    let runs: Vec<Trial> = motions
        .par_iter()
        .enumerate()
        .map(|(stream, motion)| {
            let errors = Run::new(motion, setup, seconds, stream as u64).and_then(Run::measure);
            errors
                .map(|(errors, _)| errors)
                .map_err(|kind| Lost { clip: motion.name().to_owned(), kind })
        })
        .collect();
    let mut total = Errors::default();
    for errors in runs {
        total.merge(&errors?);
    }
    Ok(total)
}

/// A rig as they come: masses off by up to 15 %, joint sensors of 12 bits, one step of latency; this one of
/// many.
#[must_use]
pub fn as_built(setup: &Setup, method: MethodName, seed: u64) -> Setup {
    let mut setup = setup.clone();
    setup.controller = setup.controller.with_method(method);
    setup.disturbance.masses = 0.15;
    setup.disturbance.sensor_bits = 12;
    setup.disturbance.latency_steps = 1;
    setup.disturbance.seed = seed;
    setup
}

/// The middle one, or the mean of the two in the middle; `None` of nothing.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    let lower = values[(values.len() - 1) / 2];
    Some(f64::midpoint(lower, upper))
}

/// A figure tracks while none is lost and the mean angular error of all bodies is below this: beyond, it
/// flails.
pub const TRACKS_BELOW_DEG: f64 = 10.0;

/// The largest latency in steps that a figure tracks at, and at every smaller one; `None` if it does not
/// track without any. The controller knows the latency and looks ahead, or does not.
///
/// # Errors
/// [`Lost`] for what is no loss of the figure: a clip that is too short, a setting that cannot be.
pub fn largest_latency(
    motions: &[impl EvaluatedMotion],
    setup: &Setup,
    look_ahead: bool,
    seconds: Option<f64>,
) -> Result<Option<usize>, Lost> {
    let mut setup = setup.clone();
    if let Some(motion) = motions.first() {
        setup.controller = setup.controller.clone().effective(narrow(motion.dt_s()));
    }
    setup.controller.observer.predict = look_ahead;
    let mut largest = None;
    for latency_steps in 0..=MAX_LATENCY_STEPS {
        setup.disturbance.latency_steps = latency_steps;
        match trial(motions, &setup, seconds) {
            Ok(errors) if errors.all.angular_mean_deg() < TRACKS_BELOW_DEG => {
                largest = Some(latency_steps);
            }
            Ok(_) => break,
            Err(lost) if lost.kind.is_loss() => break,
            Err(other) => return Err(other),
        }
    }
    Ok(largest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}
