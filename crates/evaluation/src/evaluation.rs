//! The evaluation: its protocol, its runs, and its results.

use serde::Serialize;
use sinew_core::tracker::MethodName;
use sinew_figure::Dimensions;
use sinew_rig::mechanism::JointModel;

use super::detail::Detail;
use super::error::EvaluateError;
use super::likeness::Likeness;
use super::metrics::Errors;
use super::motion::{EvaluatedMotion, count_steps};
use super::setup::Setup;
use super::step::Step;
use super::together::{Job, track_all};

/// The protocol of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Protocol {
    /// Setup of all runs. The next two fields vary it.
    pub setup: Setup,
    /// Factors on the figure's dimensions. The clip keeps its own dimensions.
    pub scales: Vec<f64>,
    /// Methods to compare.
    pub methods: Vec<MethodName>,
    /// Duration of the part of every clip that is used, from its beginning, in seconds; `None` for whole clips.
    pub seconds: Option<f64>,
}

impl Default for Protocol {
    /// Returns the paper's protocol: its three methods on a figure of equal and of 1.1 times the dimensions.
    fn default() -> Self {
        Self {
            setup: Setup::default(),
            scales: vec![1.0, 1.1],
            methods: MethodName::PAPER.to_vec(),
            seconds: None,
        }
    }
}

/// The result of an evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Evaluation {
    /// Name of the rig; `None` for the paper's figure.
    pub rig: Option<String>,
    /// Names of the bodies whose errors count: all, except the base of a user's rig on a stand.
    pub bodies: Vec<String>,
    /// Whether the base is free and driven externally, and not held by a stand.
    pub driven: bool,
    /// Setup that all runs had in common.
    pub setup: Setup,
    /// Evaluated clips in their order.
    pub clips: Vec<ClipLength>,
    /// Results of each scale, in the protocol's order.
    pub figures: Vec<FigureResult>,
}

/// The evaluated length of a clip.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct ClipLength {
    /// Name of the clip.
    pub name: String,
    /// Number of simulation steps.
    pub frames: usize,
}

/// Results of the figure at one scale.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureResult {
    /// Factor on the dimensions.
    pub scale: f64,
    /// Results of each method, in the protocol's order.
    pub methods: Vec<MethodResult>,
}

/// Results of one method on one figure.
#[derive(Debug, Clone, PartialEq)]
pub struct MethodResult {
    /// Method of measuring the state error.
    pub method: MethodName,
    /// Errors over all clips.
    pub total: Errors,
    /// Errors of each clip, in the clips' order.
    pub clips: Vec<Errors>,
    /// Details of each clip, in the clips' order.
    pub details: Vec<Detail>,
    /// Comparison of the rig with the performer of each clip, in the clips' order.
    pub likeness: Vec<Likeness>,
}

impl Evaluation {
    /// Returns how the base of a user's rig is supported, in words; `None` for the paper's figure.
    pub fn base(&self) -> Option<&'static str> {
        let how = if self.driven { "driven from outside" } else { "held by a stand" };
        self.rig.as_ref().map(|_| how)
    }

    /// Returns the number of simulation steps of one figure with one method.
    pub fn frames(&self) -> usize {
        self.clips.iter().map(|clip| clip.frames).sum()
    }
}

impl MethodResult {
    /// Returns the comparison of the rig with the performers of all clips; `None` if the motions have no
    /// performer.
    pub fn likeness(&self) -> Option<Likeness> {
        let mut all = Likeness::default();
        self.likeness.iter().for_each(|likeness| all.merge(likeness));
        (!all.total.is_empty()).then_some(all)
    }
}

impl FigureResult {
    /// Returns the result of one method, if it was evaluated.
    pub fn method(&self, name: MethodName) -> Option<&MethodResult> {
        self.methods.iter().find(|result| result.method == name)
    }
}

impl Protocol {
    /// Returns the setup of one figure and method.
    pub fn setup_of(&self, scale: f64, method: MethodName) -> Setup {
        let mut setup = self.setup.clone();
        setup.dimensions = Dimensions { scale, ..setup.dimensions };
        setup.controller = setup.controller.with_method(method);
        setup
    }
}

/// Returns the number of steps of a whole evaluation, for a progress bar.
pub fn count_all_steps(motions: &[impl EvaluatedMotion], protocol: &Protocol) -> usize {
    let frames: usize = motions.iter().map(|motion| count_steps(motion, protocol.seconds)).sum();
    frames * protocol.scales.len() * protocol.methods.len()
}

/// Tracks every motion with every method on a rig of every scale. The runs are parallel; the result does not
/// depend on the number of threads. `progress` receives the number of completed steps from time to time.
///
/// # Errors
/// The first [`EvaluateError`] in the order of scales, methods and clips. A run that diverges is an error, and is
/// never included in a mean.
pub fn evaluate<T: EvaluatedMotion>(
    motions: &[T],
    protocol: &Protocol,
    progress: impl Fn(usize) + Sync,
) -> Result<Evaluation, EvaluateError> {
    if motions.is_empty() {
        return Err(EvaluateError::NoClips);
    }
    for scale in &protocol.scales {
        for method in &protocol.methods {
            protocol.setup_of(*scale, *method).check()?;
        }
    }
    let mut setups = Vec::new();
    for scale in &protocol.scales {
        for method in &protocol.methods {
            setups.push(protocol.setup_of(*scale, *method));
        }
    }
    let jobs: Vec<Job<'_>> = setups
        .iter()
        .flat_map(|setup| {
            (0..).zip(motions).map(move |(stream, motion)| Job { motion, stream, setup })
        })
        .collect();
    let add = |job: &Job<'_>, result: &mut RunResult, step: Step<'_>| {
        result.errors.add_step(&step);
        result.detail.add(&step.errors[step.rig.first_judged()..]);
        let Likeness { retargeting, total } = &mut result.likeness;
        for (poses, angles) in [(step.desired, retargeting), (step.measured, total)] {
            job.motion.limb_errors_deg(step.frame, poses, &mut |angle| angles.add(angle));
        }
    };
    // Each run keeps its own sums, which are added in the order of the clips: identical bits every time.
    let mut results = track_all(&jobs, protocol.seconds, add, progress).into_iter();

    let clips = motions
        .iter()
        .map(|motion| ClipLength {
            name: motion.name().to_owned(),
            frames: count_steps(motion, protocol.seconds),
        })
        .collect();
    let mut figures = Vec::with_capacity(protocol.scales.len());
    for scale in &protocol.scales {
        let mut methods = Vec::with_capacity(protocol.methods.len());
        for method in &protocol.methods {
            let runs = motions.iter().zip(results.by_ref()).map(|(motion, result)| {
                result.map_err(|kind| EvaluateError::Run {
                    clip: motion.name().to_owned(),
                    scale: *scale,
                    method: *method,
                    kind,
                })
            });
            let runs = runs.collect::<Result<Vec<_>, _>>()?;
            let mut result = MethodResult {
                method: *method,
                total: Errors::default(),
                clips: Vec::with_capacity(runs.len()),
                details: Vec::with_capacity(runs.len()),
                likeness: Vec::with_capacity(runs.len()),
            };
            for RunResult { errors, detail, likeness } in runs {
                result.total.merge(&errors);
                result.clips.push(errors);
                result.details.push(detail);
                result.likeness.push(likeness);
            }
            methods.push(result);
        }
        figures.push(FigureResult { scale: *scale, methods });
    }
    let rig = motions.iter().find_map(|motion| motion.rig_name().map(str::to_owned));
    // Every run has already made this rig successfully.
    let made = motions.first().and_then(|motion| motion.rig(&protocol.setup).ok());
    let links = made.as_ref().map_or(&[][..], |rig| &rig.links()[rig.first_judged()..]);
    let bodies = links.iter().map(|link| link.name.clone()).collect();
    let driven = made.is_some_and(|rig| rig.links()[0].joint == JointModel::Free);
    Ok(Evaluation { rig, bodies, driven, setup: protocol.setup.clone(), clips, figures })
}

/// Results of one run.
#[derive(Debug, Default)]
struct RunResult {
    errors: Errors,
    detail: Detail,
    likeness: Likeness,
}
