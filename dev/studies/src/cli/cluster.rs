//! `sinew-studies cluster`: walking and running, by two clusters.

use std::num::NonZeroUsize;

use sinew_host_util::command::with_progress;
use sinew_studies::pictures::write_cluster;
use sinew_studies::spatial::cluster::{self, Pairing, Plan};
use sinew_studies::spatial::cost;

use super::data::count;
use super::two_classes::TwoClassesArgs;

/// Separate walking from running by two clusters of poses, with every distance of poses.
///
/// The study repeats S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and
/// understanding" (2012), who classified 65 % correctly by the geodesic line and 60 % by joint angles. Medoid shift
/// with a Gaussian kernel clusters the poses of a sequence of walking and one of running, with the smallest of 101
/// bandwidths that makes two clusters. The clusters are assigned to the sequences in the way that fits better, so even
/// chance classifies more than half correctly; for comparison, the table has the results of a single cluster and of
/// clusters with random members. The longer sequence has more weight, so pairs are also cut to equal length. Two
/// sequences differ in more than their class, so there are also pairs of one person's walking and running, and of two
/// people's walking.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: TwoClassesArgs,

    /// Number of pairs of sequences to draw. Default: 100, or 5 with `--quick`.
    #[arg(long, value_name = "N", value_parser = count)]
    pairs: Option<NonZeroUsize>,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let Args { common, pairs } = args;
    let results = common.results.open("cluster")?;
    let classes = common.read()?;
    let rig = common.rig(&classes)?;
    let usual = if common.is_quick() { 5 } else { 100 };
    let plan = Plan {
        classes: &classes,
        rig: &rig,
        measures: common.measures(),
        pairs: pairs.map_or(usual, NonZeroUsize::get),
        seed: common.seed,
    };
    let steps = plan.measures.len() * Pairing::ALL.len() * plan.pairs;
    let study = with_progress(steps, |progress| {
        common.threads.install(|| Ok(cluster::run(&plan, progress)?))
    })?;
    let costs =
        if common.no_times { Vec::new() } else { cost::of(&classes, &rig, &plan.measures)? };
    results.write(
        &cluster::tables(&plan, &study, &costs),
        &cluster::json(&plan, &study, &costs),
        |folder| write_cluster(&plan, &study, folder),
    )
}
