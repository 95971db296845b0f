//! `sinew-studies cluster`: walking and running, by two clusters.

use std::num::NonZeroUsize;

use sinew_studies::pictures::write_cluster;
use sinew_studies::spatial::cluster::{self, Pairing, Plan};
use sinew_studies::spatial::cost;

use sinew_sim::command::with_progress;

use super::two_classes::TwoClassesArgs;

/// Tell walking from running by two clusters of poses, with every distance of poses.
///
/// After S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and understanding" (2012),
/// that had 65 % right by the geodesic line and 60 % by joint angles. Of the poses of a sequence of walking and one of
/// running, medoid shift with a Gaussian kernel makes clusters: with the smallest of a hundred bandwidths that makes two.
/// Both are called by the sequences in the way that fits better; so clusters that mean nothing have more than half right,
/// which is why the table tells what one cluster, and members by chance, would have. The longer sequence weighs more, so
/// they are also cut to one length; and since two sequences differ in more than their class, there are also pairs of one
/// person's walking and running, and of two people's walking.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    common: TwoClassesArgs,

    /// How many pairs of sequences are drawn. Without: 100, or 5 with `--quick`.
    #[arg(long, value_name = "N")]
    pairs: Option<NonZeroUsize>,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let Args { common, pairs } = args;
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
    common.results.write(
        "cluster",
        &cluster::tables(&plan, &study, &costs),
        &cluster::json(&plan, &study, &costs),
        |folder| write_cluster(&plan, &study, folder),
    )
}
