//! `sinew-studies geodesic-ratio`: ratio of geodesics to the lines that approximate them.

use std::num::NonZeroU16;

use sinew_host_util::command::{ThreadArgs, with_progress};
use sinew_studies::pictures::write_geodesic_ratio;
use sinew_studies::recordings::Recordings;
use sinew_studies::spatial::geodesic_ratio::{self, Plan};

use super::data::DataArgs;
use super::results::ResultArgs;

/// Compare geodesics with the straight lines that approximate them: how much longer is a line?
///
/// The study repeats S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and
/// understanding" (2012), eq. (8): r = L(geodesic) / L(line) of random pairs of poses from walking. They find no r
/// below 0.94. All joints are ball joints, the root is left out, all poses are on one skeleton (CMU's 31 joints).
///
/// Further conditions change one thing each: the origin of pairs, the steps, the coordinates of the line, the joints
/// that count, and the kind of motion. Two further tables group the pairs of the first condition, by the largest turn
/// of a joint and by the length of the line.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    data: DataArgs,

    /// Pairs of poses for each condition.
    #[arg(long, value_name = "N", default_value = "100")]
    pairs: NonZeroU16,

    /// Seed of the draws.
    #[arg(long, value_name = "N", default_value = "1")]
    seed: u64,

    /// Steps of a curve; some conditions use twice and four times as many.
    #[arg(long, value_name = "N", default_value = "10", value_parser = clap::value_parser!(u16).range(2..=1000))]
    steps: u16,

    /// Joint relative to which poses are compared. Default: the skeleton's root.
    #[arg(long, value_name = "JOINT")]
    root: Option<String>,

    #[command(flatten)]
    results: ResultArgs,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let results = args.results.open("geodesic-ratio")?;
    let recordings = match args.data.folder()? {
        Some(data) => Recordings::cmu(&data.join("cmu"))?,
        None => Recordings::built_in(),
    };
    let plan = Plan {
        recordings: &recordings,
        root: args.root.as_deref(),
        pairs: usize::from(args.pairs.get()),
        seed: args.seed,
        steps: usize::from(args.steps),
    };
    let conditions = plan.conditions();
    let outcomes = args.threads.install(|| {
        Ok(with_progress(conditions.len() * plan.pairs, |progress| {
            geodesic_ratio::run(&plan, &conditions, progress)
        })?)
    })?;
    results.write(
        &geodesic_ratio::tables(&plan, &outcomes),
        &geodesic_ratio::json(&plan, &outcomes),
        |out| write_geodesic_ratio(&outcomes, out),
    )
}
