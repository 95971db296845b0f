//! `sinew evaluate sweep`: an evaluation of many setups.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use sinew_evaluation::sweep::{self, Journal, Plan, Shard, SweepFile};
use sinew_evaluation::{EvaluatedMotion as _, count_steps};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};
use sinew_performance::rig::LoadedRig;

use super::clips::{ClipArgs, seconds, tell};
use super::output::OutputPlace;
use super::performance::PerformanceArgs;

/// Run every combination of many settings and write a row for each.
///
/// The file contains the settings that all runs share, and grids of those that vary:
///
///     setup.plant.kind = "articulated"
///
///     [[grid]]
///     controller.method = ["local", "world"]
///     dimensions.scale = [0.9, 1.0, 1.1]
///
/// Each combination is a cell. The keys are those of `sinew evaluate --format json`, under
/// "setup". A setup that is in two grids is run once. Wrong keys and values are refused
/// before anything runs.
///
/// Every finished run is written to DIR/journal.jsonl at once: to resume, run the same
/// command again. At the end sweep.csv and sweep.parquet have a row per cell,
/// `sweep_clips.*` a row per cell and clip. Their bytes do not depend on interruptions,
/// threads or the number of machines. If a figure is lost (flies apart), its row has no
/// numbers, but a reason.
///
/// The column `on_front` marks the Pareto-optimal rows of a task: no other row has smaller
/// mean errors of all joints, both angular and linear. A task is all settings except those
/// of the controller and how the root is held. In a shard the column is empty.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The sweep, in TOML.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Folder of the journal and the tables.
    #[arg(long, value_name = "DIR")]
    output: OutputPlace,

    #[command(flatten)]
    clips: ClipArgs,

    /// Use only the first S seconds of every clip.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    /// Run only every N-th cell, starting with the I-th. Afterwards `--merge` the folders of all N.
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    shard: Option<Shard>,

    /// Run nothing: merge the journals of these folders, and write the tables of all runs.
    #[arg(long, value_name = "DIR", num_args = 1..)]
    merge: Vec<PathBuf>,

    /// Run nothing: print the runs.
    #[arg(long)]
    dry_run: bool,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand. A lost figure (one that flies apart) is a result, not an error.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.clips.in_pool(&args.threads, &PerformanceArgs::default(), |rig| run_on(args, rig))
}

fn run_on(args: &Args, rig: Option<&LoadedRig>) -> anyhow::Result<ExitCode> {
    let file = SweepFile::read(&args.file, rig.map(|rig| &rig.mechanism))?;
    if file.repeated > 0 {
        note(format_args!(
            "{}: {} cells are left out, an earlier grid has the same setup",
            args.file.display(),
            file.repeated
        ));
    }
    let (motions, lines) = args.clips.takes(rig)?;
    tell(&lines);
    for motion in &motions {
        let steps = count_steps(motion, args.seconds);
        ensure!(steps > 0, "clip {}: at least 3 frames are needed", motion.name());
    }
    let shard = args.shard.unwrap_or(Shard::WHOLE);
    let plan = Plan::new(file, &motions, args.seconds, shard);
    if args.dry_run {
        let (cells, runs) = (plan.shard_cells().count(), plan.units().count());
        let steps = plan.count_steps(&motions);
        print(&format!("{cells} cells, {runs} runs, {steps} steps\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let (journal, notices) = Journal::open(&args.output, &plan)?;
    for notice in notices {
        note(format_args!("{}: {notice}", args.output.display()));
    }
    let summary = if args.merge.is_empty() {
        let steps = sweep::count_missing_steps(&plan, &journal, &motions);
        with_progress(steps, |progress| sweep::sweep(&plan, journal, &motions, progress))?
    } else {
        sweep::merge(&plan, journal, &args.merge)?
    };
    print(&summary.text(&plan))?;
    Ok(ExitCode::SUCCESS)
}
