//! `sinew-studies mds`: embeds motion by multidimensional scaling, and compares how many dimensions each measure of
//! poses needs.

use std::num::NonZeroU16;
use std::path::PathBuf;

use anyhow::{Context as _, ensure};
use sinew_host_util::command::{ThreadArgs, with_progress};
use sinew_studies::pictures::write_mds;
use sinew_studies::recordings::{Recordings, Sequence, broad};
use sinew_studies::spatial::components::{self, Plan};

use super::data::DataArgs;
use super::results::ResultArgs;

/// Embed motion by multidimensional scaling and Isomap: how much of it is in one dimension, by each measure of poses?
///
/// The study repeats S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and
/// understanding" (2012), figure 4 and the test after it. The measures are: differences of joint coordinates (angles),
/// rotations times bone lengths (rotations), positions of joints, and the geodesic line; each with equal weights of all
/// joints, and with weights by importance.
///
/// Two people's walks, on one skeleton, are embedded together. Then every broad recording at 12 Hz is embedded alone,
/// on its own skeleton, and the share of its first component is computed.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    #[command(flatten)]
    data: DataArgs,

    /// The two walks: files of CMU's 31-joint skeletons, relative to the data set's folder.
    #[arg(
        long,
        value_name = "FILE",
        num_args = 2,
        default_values = WALKS,
        conflicts_with = "quick"
    )]
    walks: Vec<String>,

    /// Steps in which a line is sampled.
    #[arg(long, value_name = "N", default_value = "10")]
    steps: NonZeroU16,

    /// Number of nearest poses to which Isomap connects every pose.
    #[arg(long, value_name = "N", default_value = "7", value_parser = clap::value_parser!(u16).range(1..=1000))]
    neighbours: u16,

    /// Joint relative to which poses are compared; of several, the first that a skeleton has. Default: the skeleton's
    /// root.
    #[arg(long, value_name = "JOINT,..", value_delimiter = ',')]
    root: Vec<String>,

    #[command(flatten)]
    results: ResultArgs,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Walks of subjects 07 and 35, straight on.
const WALKS: [&str; 2] = ["broad-12hz/07_01.bvh", "broad-12hz/35_01.bvh"];

/// Runs the subcommand.
pub(super) fn run(args: &Args) -> anyhow::Result<()> {
    let results = args.results.open("mds")?;
    let (walking, broad, walks) = if let Some(data) = args.data.folder()? {
        (Recordings::cmu(&data.join("cmu"))?, broad(&data)?, args.walks.clone())
    } else {
        let clips = Recordings::built_in();
        let walks = clips.sequences[..2].iter().map(|clip| clip.file.clone()).collect();
        (clips.clone(), vec![clips], walks)
    };
    let [first, second] = [&walks[0], &walks[1]].map(|file| find(&walking, file));
    let plan = Plan {
        skeleton: &walking.skeleton,
        walks: [first?, second?],
        broad: &broad,
        roots: &args.root,
        steps: args.steps.get(),
        neighbours: usize::from(args.neighbours),
    };
    let study = args.threads.install(|| {
        Ok(with_progress(plan.steps(), |progress| components::run(&plan, progress))?)
    })?;
    let walkers = plan.walks.map(walker);
    results.write(&components::tables(&plan, &study), &components::json(&plan, &study), |out| {
        write_mds(&study, [&walkers[0], &walkers[1]], out)
    })
}

fn find<'r>(recordings: &'r Recordings, file: &str) -> anyhow::Result<&'r Sequence> {
    let found = recordings.sequences.iter().find(|sequence| sequence.file == file);
    let sequence = found.with_context(|| {
        format!("{file}: expected a recording of CMU's 31-joint skeletons, such as {}", WALKS[0])
    })?;
    ensure!(sequence.frames.len() > 1, "{file}: expected more than one pose");
    Ok(sequence)
}

/// Returns a walk's name for a legend.
fn walker(walk: &Sequence) -> String {
    let file = PathBuf::from(&walk.file);
    let stem = file.file_stem().unwrap_or_default().to_string_lossy();
    if walk.trial.is_empty() {
        stem.into_owned()
    } else {
        format!("subject {}, {stem}", walk.subject)
    }
}
