//! The parts of a page of an evaluation.

use sinew_evaluation::Evaluation;
use sinew_evaluation::optimum::Optimum;

use super::comparison::Comparison;
use super::playback::Playback;
use super::sweep::Sweep;

/// The content of the page.
#[derive(Debug, Clone, Copy)]
pub struct Report<'a> {
    /// Command that made the page.
    pub command: &'a str,
    /// Settings such as the plant: name and value.
    pub settings: &'a [(&'a str, String)],
    /// Notices about the preparation of the clips or the rig: skipped, filled, found.
    pub notices: &'a [String],
    /// Result of the evaluation.
    pub evaluation: &'a Evaluation,
    /// Time from one frame to the next, in seconds.
    pub dt_s: f64,
    /// The paper's Figure 4; `None` for other rigs.
    pub comparison: Option<&'a Comparison>,
    /// Nearest poses of every figure, for the evaluation's scales; `None` for other rigs.
    pub optimum: Option<&'a Optimum>,
    /// Playback of one clip, or of one motion of a rig.
    pub playback: Option<&'a Playback>,
    /// A sweep to show with the evaluation.
    pub sweep: Option<&'a Sweep>,
}
