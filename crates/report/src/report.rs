//! The parts that a page of an evaluation is made of.

use sinew_evaluation::Evaluation;
use sinew_evaluation::optimum::Optimum;

use super::comparison::Comparison;
use super::playback::Playback;
use super::sweep::Sweep;

/// What the page shows.
#[derive(Debug, Clone, Copy)]
pub struct Report<'a> {
    /// The command that made it.
    pub command: &'a str,
    /// What was set, such as the plant: name and value.
    pub settings: &'a [(&'a str, String)],
    /// What was done to the clips or the rig before: skipped, filled, found.
    pub notices: &'a [String],
    /// The result.
    pub evaluation: &'a Evaluation,
    /// Time from one frame to the next, in seconds.
    pub dt_s: f64,
    /// The paper's Figure 4; none of other rigs.
    pub comparison: Option<&'a Comparison>,
    /// The nearest poses of every figure, of the same scales; none of other rigs.
    pub optimum: Option<&'a Optimum>,
    /// One clip, or motion of a rig, as it was followed.
    pub playback: Option<&'a Playback>,
    /// A sweep beside the evaluation.
    pub sweep: Option<&'a Sweep>,
}
