//! A trial: all motions with one setup.

use super::error::RunError;
use super::metrics::Errors;
use super::motion::EvaluatedMotion;
use super::setup::Setup;
use super::step::Step;
use super::together::{Job, track_all};

/// Limit of the mean angular error of all bodies, in degrees. A figure counts as tracking if the error is below the
/// limit and no run is lost. Above the limit, the figure flails.
pub const TRACKS_BELOW_DEG: f64 = 10.0;

/// The errors of one setup over all clips, or the first clip whose run failed.
pub type Trial = Result<Errors, Lost>;

/// The failure of a run: the figure was lost, or the run was not possible.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{clip}: {kind}")]
pub struct Lost {
    /// Name of the clip.
    pub clip: String,
    /// Reason for the failure.
    pub kind: RunError,
}

/// Tracks all clips with one setup, in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// [`Lost`] for the first clip, in their order, whose run failed.
pub fn run_trial(motions: &[impl EvaluatedMotion], setup: &Setup, seconds: Option<f64>) -> Trial {
    let jobs: Vec<Job<'_>> =
        (0..).zip(motions).map(|(stream, motion)| Job { motion, stream, setup }).collect();
    let add = |_: &Job<'_>, errors: &mut Errors, step: Step<'_>| errors.add_step(&step);
    let mut total = Errors::default();
    for (errors, motion) in track_all(&jobs, seconds, add, |_| ()).into_iter().zip(motions) {
        let errors = errors.map_err(|kind| Lost { clip: motion.name().to_owned(), kind })?;
        total.merge(&errors);
    }
    Ok(total)
}
