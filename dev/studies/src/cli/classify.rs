//! `sinew-studies classify`: walking or running, by the nearest pose.

use std::num::NonZeroUsize;

use sinew_host_util::command::with_progress;
use sinew_studies::pictures::write_classify;
use sinew_studies::spatial::classify::{self, Plan};
use sinew_studies::spatial::cost;

use super::data::count;
use super::two_classes::TwoClassesArgs;

/// Classify walking and running by the nearest pose, with every distance of poses.
///
/// The study repeats S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and
/// understanding" (2012), who classified 100 % correctly by the geodesic line and 90 % by joint angles. In many
/// draws, ten sequences of walking and ten of running are chosen; every pose gets the class of its nearest neighbour
/// among the other sequences' poses. The study is repeated with neighbours of other people only (of another style in
/// Bandai's recordings, which name no people). The root's place and orientation do not count. The run also measures
/// the time of the distances.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: TwoClassesArgs,

    /// Sequences of each class in a draw. Default: 10, or 3 with `--quick`.
    #[arg(long, value_name = "N", value_parser = count)]
    each: Option<NonZeroUsize>,

    /// Draws of sequences. Default: 50, or 5 with `--quick`.
    #[arg(long, value_name = "N", value_parser = count)]
    draws: Option<NonZeroUsize>,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let Args { common, each, draws } = args;
    let results = common.results.open("classify")?;
    let classes = common.read()?;
    let rig = common.rig(&classes)?;
    let of = |given: &Option<NonZeroUsize>, full: usize, quick: usize| {
        given.map_or(if common.is_quick() { quick } else { full }, NonZeroUsize::get)
    };
    let plan = Plan {
        classes: &classes,
        rig: &rig,
        measures: common.measures(),
        each: of(each, 10, 3),
        draws: of(draws, 50, 5),
        seed: common.seed,
    };
    let study = with_progress(plan.steps(), |progress| {
        common.threads.install(|| Ok(classify::run(&plan, progress)?))
    })?;
    let costs =
        if common.no_times { Vec::new() } else { cost::of(&classes, &rig, &plan.measures)? };
    results.write(
        &classify::tables(&plan, &study, &costs),
        &classify::json(&plan, &study, &costs),
        |folder| write_classify(&plan, &study, folder),
    )
}
