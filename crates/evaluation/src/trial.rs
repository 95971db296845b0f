//! A trial: all motions with one setup.

use rayon::prelude::*;

use super::error::RunError;
use super::metrics::Errors;
use super::motion::EvaluatedMotion;
use super::run::Run;
use super::setup::Setup;

/// A figure tracks while none is lost and the mean angular error of all bodies is below this: beyond, it
/// flails.
pub const TRACKS_BELOW_DEG: f64 = 10.0;

/// The errors of one setup over all clips, or the clip that the figure was lost on.
pub type Trial = Result<Errors, Lost>;

/// A loss of a figure.
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
pub fn run_trial(motions: &[impl EvaluatedMotion], setup: &Setup, seconds: Option<f64>) -> Trial {
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
