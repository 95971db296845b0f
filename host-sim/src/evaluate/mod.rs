//! The paper's evaluation: every clip, tracked by a figure of every scale with every method of measuring
//! its state error, and how far off it was.

mod error;
mod metrics;
pub mod paper;
mod reference;
pub mod report;
mod track;

use std::fmt;

use rayon::prelude::*;
use serde::Serialize;
use sinew_core::Tree;
use sinew_core::state_error::{Aims, Compensation, Method};

use crate::figure::{BODY_COUNT, BodyModel};
use crate::mocap::FigureMotion;

pub use error::{EvaluateError, RunError};
pub use metrics::{ErrorTotals, Errors};
pub use track::{Step, track};

/// A method of measuring the state error, as tables and options name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum MethodName {
    /// Local Space Error.
    Local,
    /// World Space Error.
    World,
    /// Linear Compensation Error, β = 1, every body aiming at its heaviest child.
    LinearCompensation,
}

impl MethodName {
    /// The paper's three, in its order.
    pub const ALL: [Self; 3] = [Self::Local, Self::World, Self::LinearCompensation];

    /// The name in options and files.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Local => "local",
            Self::World => "world",
            Self::LinearCompensation => "linear_compensation",
        }
    }

    /// The method for a figure.
    pub fn method(self, tree: &Tree<BODY_COUNT>) -> Method<BODY_COUNT> {
        match self {
            Self::Local => Method::Local,
            Self::World => Method::World,
            Self::LinearCompensation => Method::LinearCompensation {
                aims: Aims::heaviest_child(tree),
                settings: Compensation::default(),
            },
        }
    }
}

impl fmt::Display for MethodName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

/// What to evaluate.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// Factors on the figure's dimensions; the clip keeps its own.
    pub scales: Vec<f64>,
    /// Methods to compare.
    pub methods: Vec<MethodName>,
    /// Use only this much of the beginning of every clip, in seconds.
    pub seconds: Option<f64>,
}

impl Default for Protocol {
    /// The paper's: its three methods on a figure of equal and of 1.1 times the dimensions.
    fn default() -> Self {
        Self { scales: vec![1.0, 1.1], methods: MethodName::ALL.to_vec(), seconds: None }
    }
}

/// The whole result.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// The clips in their order.
    pub clips: Vec<ClipLength>,
    /// One per scale, in the protocol's order.
    pub figures: Vec<FigureResult>,
}

/// How much of a clip was evaluated.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClipLength {
    /// The clip's name.
    pub name: String,
    /// Number of simulation steps.
    pub frames: usize,
}

/// Results of a figure of one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureResult {
    /// Factor on the dimensions.
    pub scale: f64,
    /// One per method, in the protocol's order.
    pub methods: Vec<MethodResult>,
}

/// Results of one method on one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodResult {
    /// The method.
    pub method: MethodName,
    /// Over all clips.
    pub total: Errors,
    /// By clip, in the clips' order.
    pub clips: Vec<Errors>,
}

impl Evaluation {
    /// Number of simulation steps of one figure with one method.
    pub fn frames(&self) -> usize {
        self.clips.iter().map(|clip| clip.frames).sum()
    }
}

impl FigureResult {
    /// The result of one method, if it was evaluated.
    pub fn method(&self, name: MethodName) -> Option<&MethodResult> {
        self.methods.iter().find(|result| result.method == name)
    }
}

/// Steps that a whole evaluation takes, for a progress bar.
pub fn step_count(motions: &[FigureMotion], protocol: &Protocol) -> usize {
    let frames: usize =
        motions.iter().map(|motion| track::step_count(motion, protocol.seconds)).sum();
    frames * protocol.scales.len() * protocol.methods.len()
}

/// Tracks every clip with every method on a figure of every scale. Runs in parallel; the result does not
/// depend on the number of threads. `progress` is told the number of steps done, now and then.
///
/// # Errors
/// The first [`EvaluateError`] in the order of scales, methods and clips. A run that diverges is an error,
/// never part of a mean.
pub fn evaluate(
    motions: &[FigureMotion],
    protocol: &Protocol,
    progress: impl Fn(usize) + Sync,
) -> Result<Evaluation, EvaluateError> {
    if motions.is_empty() {
        return Err(EvaluateError::NoClips);
    }
    let models = motions
        .iter()
        .map(|motion| {
            BodyModel::from_motion(motion)
                .map_err(|source| EvaluateError::Model { clip: motion.name.clone(), source })
        })
        .collect::<Result<Vec<_>, _>>()?;

    let mut runs = Vec::new();
    for scale in &protocol.scales {
        for method in &protocol.methods {
            for (motion, model) in motions.iter().zip(&models) {
                runs.push((*scale, *method, motion, model));
            }
        }
    }
    // Each run keeps its own sums, and they are added in the order of the clips: same bits every time.
    let results: Vec<Result<Errors, EvaluateError>> = runs
        .par_iter()
        .map(|(scale, method, motion, model)| {
            let (errors, steps) = run(motion, &model.scaled(*scale), *method, protocol.seconds)
                .map_err(|kind| EvaluateError::Run {
                    clip: motion.name.clone(),
                    scale: *scale,
                    method: *method,
                    kind,
                })?;
            progress(steps);
            Ok(errors)
        })
        .collect();

    let clips = motions
        .iter()
        .map(|motion| ClipLength {
            name: motion.name.clone(),
            frames: track::step_count(motion, protocol.seconds),
        })
        .collect();
    let mut results = results.into_iter();
    let mut figures = Vec::with_capacity(protocol.scales.len());
    for scale in &protocol.scales {
        let mut methods = Vec::with_capacity(protocol.methods.len());
        for method in &protocol.methods {
            let clips = results.by_ref().take(motions.len()).collect::<Result<Vec<_>, _>>()?;
            let mut total = Errors::default();
            for clip in &clips {
                total.merge(clip);
            }
            methods.push(MethodResult { method: *method, total, clips });
        }
        figures.push(FigureResult { scale: *scale, methods });
    }
    Ok(Evaluation { clips, figures })
}

/// Errors of one run, and its number of steps.
fn run(
    motion: &FigureMotion,
    model: &BodyModel,
    method: MethodName,
    seconds: Option<f64>,
) -> Result<(Errors, usize), RunError> {
    let method = method.method(&model.tree()?);
    let mut errors = Errors::default();
    let steps =
        track(motion, model, method, seconds, |step| errors.add(step.desired, step.measured))?;
    Ok((errors, steps))
}

#[cfg(test)]
mod tests;
