//! Options that `sinew-studies classify` and `sinew-studies cluster` share.

use std::num::NonZeroU16;

use sinew_host_util::command::ThreadArgs;
use sinew_pose_metrics::spatial::{Measure, SpatialRig};
use sinew_studies::spatial::classes::TwoClasses;

use super::data::RecordingArgs;
use super::results::ResultArgs;

#[derive(Debug, clap::Args)]
pub(super) struct TwoClassesArgs {
    #[command(flatten)]
    recordings: RecordingArgs,

    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value = "1")]
    pub(super) seed: u64,

    /// Steps in which lines are sampled.
    #[arg(long, value_name = "N", default_value = "10")]
    steps: NonZeroU16,

    /// Joint relative to which poses are compared. Default: the skeleton's root.
    #[arg(long, value_name = "JOINT")]
    root: Option<String>,

    #[command(flatten)]
    pub(super) results: ResultArgs,

    /// Do not measure the time of the distances.
    #[arg(long)]
    pub(super) no_times: bool,

    #[command(flatten)]
    pub(super) threads: ThreadArgs,
}

impl TwoClassesArgs {
    /// Returns whether this is a short test on built-in clips.
    pub(super) const fn is_quick(&self) -> bool {
        self.recordings.data.quick
    }

    /// Reads the recordings and selects the two classes.
    pub(super) fn read(&self) -> anyhow::Result<TwoClasses> {
        Ok(TwoClasses::of(&self.recordings.read()?)?)
    }

    /// Returns the rig for the poses.
    pub(super) fn rig(&self, classes: &TwoClasses) -> anyhow::Result<SpatialRig> {
        Ok(SpatialRig::new(&classes.skeleton, self.root.as_deref())?)
    }

    /// Returns all distances, with the steps of the option.
    pub(super) fn measures(&self) -> Vec<Measure> {
        Measure::all().map(|measure| Measure { steps: self.steps.get(), ..measure }).collect()
    }
}
