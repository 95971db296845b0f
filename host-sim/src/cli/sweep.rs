//! `sinew evaluate sweep`: many setups.

use std::path::PathBuf;
use std::process::ExitCode;

use anyhow::ensure;
use sinew_evaluation::sweep::{self, Journal, ParetoFront, Plan, Shard, Summary, SweepFile};
use sinew_evaluation::{Errors, EvaluatedMotion as _, count_steps};
use sinew_host_util::command::{ThreadArgs, note, print, with_progress};

use super::clips::{ClipArgs, seconds, tell};
use super::performance::PerformanceArgs;

/// Run every combination of many settings and write a row for each.
///
/// The file holds the settings that all runs have in common, and grids of those that vary:
///
///     setup.plant.kind = "articulated"
///
///     [[grid]]
///     controller.method = ["local", "world"]
///     dimensions.scale = [0.9, 1.0, 1.1]
///
/// Each combination is a cell. The keys are those of `sinew evaluate --format json`,
/// under "setup". A setup that is in two grids is run once. Wrong keys and values are
/// refused before anything runs.
///
/// Every finished run goes to DIR/journal.jsonl at once: to resume, run the same command
/// again. At the end sweep.csv and sweep.parquet have a row per cell, `sweep_clips.*` a
/// row per cell and clip. Their bytes do not depend on interruptions, threads or the
/// number of machines. If a figure is lost, its row has no numbers, and says why.
///
/// The column `on_front` marks the Pareto-optimal rows of a task: no other row has smaller
/// mean errors of all joints, both angular and linear. A task is all settings but those of
/// the controller, and how the root is held. In a shard the column is empty.
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(super) struct Args {
    /// The sweep, in TOML.
    #[arg(value_name = "FILE")]
    file: PathBuf,

    /// Folder of the journal and the tables.
    #[arg(long, value_name = "DIR")]
    output: PathBuf,

    #[command(flatten)]
    clips: ClipArgs,

    /// Use only the first S seconds of every clip.
    #[arg(long, value_name = "S", value_parser = seconds, allow_negative_numbers = true)]
    seconds: Option<f64>,

    /// Run only every N-th cell, from the I-th on. Then `--merge` the folders of all N.
    #[arg(long, value_name = "I/N", conflicts_with = "merge")]
    shard: Option<Shard>,

    /// Run nothing: merge the journals of these folders, and write the tables of the whole.
    #[arg(long, value_name = "DIR", num_args = 1..)]
    merge: Vec<PathBuf>,

    /// Run nothing: print what would be run.
    #[arg(long)]
    dry_run: bool,

    #[command(flatten)]
    threads: ThreadArgs,
}

/// Runs the subcommand. Lost figures are results: they do not make it fail.
pub(super) fn run(args: &Args) -> anyhow::Result<ExitCode> {
    args.threads.install(|| run_in_pool(args))
}

fn run_in_pool(args: &Args) -> anyhow::Result<ExitCode> {
    let rig = args.clips.rig(&PerformanceArgs::default())?;
    let rig = rig.as_ref();
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
        let steps: usize =
            plan.units().map(|unit| count_steps(&motions[unit.clip], args.seconds)).sum();
        print(&format!("{cells} cells, {runs} runs, {steps} steps\n"))?;
        return Ok(ExitCode::SUCCESS);
    }
    let (journal, notices) = Journal::open(&args.output, &plan)?;
    for notice in notices {
        note(format_args!("{}: {notice}", args.output.display()));
    }
    let summary = if args.merge.is_empty() {
        let steps = sweep::steps_left(&plan, &journal, &motions);
        with_progress(steps, |progress| sweep::sweep(&plan, journal, &motions, progress))?
    } else {
        sweep::merge(&plan, journal, &args.merge)?
    };
    print(&told(&summary, &plan))?;
    Ok(ExitCode::SUCCESS)
}

fn told(summary: &Summary, plan: &Plan) -> String {
    let Summary { cells, run, resumed, lost, ranking, fronts, files } = summary;
    let mut lines = vec![format!("{cells} cells; {run} runs made, {resumed} taken over")];
    if *lost > 0 {
        lines.push(format!("the figure was lost in {lost} cells"));
    }
    let own = own_settings(plan);
    if !fronts.is_empty() {
        lines.push("front of mean linear over mean angular error of all joints:".to_owned());
        lines.extend(fronts.iter().take(FRONTS).flat_map(|front| of_front(front, &own)));
        if fronts.len() > FRONTS {
            lines.push(format!("  and of {} more tasks, see on_front", fronts.len() - FRONTS));
        }
    }
    if ranking.len() > 1 {
        lines.push("mean linear error of all bodies, smallest and largest:".to_owned());
        lines.extend(extremes(ranking, &own));
    }
    lines.extend(files.iter().map(|file| file.display().to_string()));
    lines.push(String::new());
    lines.join("\n")
}

/// How many cells of either end are shown.
const SHOWN: usize = 3;

/// How many fronts are shown, and how many cells of each.
const FRONTS: usize = 8;
const FRONT_CELLS: usize = 20;

/// Of every cell, what not all cells have in common.
fn own_settings(plan: &Plan) -> Vec<Vec<String>> {
    let mut own: Vec<Vec<String>> =
        plan.cells.iter().map(|cell| cell.setup.differences()).collect();
    let common: Vec<String> = own[0]
        .iter()
        .filter(|line| own.iter().all(|lines| lines.contains(line)))
        .cloned()
        .collect();
    for lines in &mut own {
        lines.retain(|line| !common.contains(line));
    }
    own
}

/// The task of a front, and its cells.
fn of_front(front: &ParetoFront, own: &[Vec<String>]) -> Vec<String> {
    let is_task = |line: &&String| !line.starts_with("controller.");
    let listed = |lines: Vec<&str>| match lines.as_slice() {
        [] => "nothing else set".to_owned(),
        lines => lines.join(", "),
    };
    let cells = front.cells.iter().take(FRONT_CELLS);
    let mut lines: Vec<String> = cells
        .map(|(cell, errors)| {
            let set = own[*cell].iter().filter(|line| !is_task(line)).map(String::as_str).collect();
            let (angular, linear) = (errors.all.angular_mean_deg(), errors.all.linear_mean_cm());
            let weighted = errors.weighted.mean_cm();
            format!("  {angular:>9.4} deg {linear:>9.4} cm {weighted:>9.4} cm weighted  cell {cell:<5} {}", listed(set))
        })
        .collect();
    if let Some((first, _)) = front.cells.first() {
        let task = own[*first].iter().filter(is_task).map(String::as_str).collect();
        let heading = format!("  {} of {} cells; {}", front.cells.len(), front.of, listed(task));
        lines.insert(0, heading);
    }
    if front.cells.len() > FRONT_CELLS {
        lines.push(format!("  and {} more", front.cells.len() - FRONT_CELLS));
    }
    lines
}

/// The first and last cells of a ranking.
fn extremes(ranking: &[(usize, Errors)], own: &[Vec<String>]) -> Vec<String> {
    let last = ranking.len().saturating_sub(SHOWN).max(SHOWN);
    let ends = ranking.iter().take(SHOWN).chain(ranking.iter().skip(last));
    ends.map(|(cell, errors)| {
        let own = if own[*cell].is_empty() {
            "nothing else set".to_owned()
        } else {
            own[*cell].join(", ")
        };
        format!("  {:>9.4} cm  cell {cell:<5} {own}", errors.all.linear_mean_cm())
    })
    .collect()
}
