//! Sweeps: many setups on many clips, in parallel, on several machines, and resumable.
//!
//! A sweep file contains grids of values; each combination is a cell, a [`Setup`](crate::Setup) of its own. A unit
//! is one cell on one clip. Each thread tracks up to 8 units together, and writes them to a journal when all of them
//! are finished. An interrupted sweep resumes from the journal, and repeats the units that were not written. The tables
//! are written from the complete journal, and are the same bytes however often the sweep was interrupted.

mod error;
mod file;
mod journal;
mod pareto;
mod plan;
mod summary;
mod table;

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use rayon::prelude::*;

use crate::metrics::Errors;
use crate::motion::{EvaluatedMotion, count_steps};
use crate::step::Step;
use crate::together::{Job, make_groups, track_together};

pub use error::SweepError;
pub use file::{Cell, SweepFile};
pub use journal::{Journal, Notice, Outcome};
pub use pareto::ParetoFront;
pub use plan::{Plan, Shard, Unit};
pub use summary::Summary;

/// Counts the steps of the units that the journal lacks, for a progress bar.
pub fn count_missing_steps(
    plan: &Plan,
    journal: &Journal,
    motions: &[impl EvaluatedMotion],
) -> usize {
    let missing = plan.units().filter(|unit| !journal.has(*unit));
    missing.map(|unit| count_steps(&motions[unit.clip], plan.seconds)).sum()
}

/// Runs the units that the journal lacks, then writes the tables to the journal's folder. `progress` receives the
/// number of completed steps from time to time.
///
/// # Errors
/// [`SweepError`] if the journal or a table cannot be written. Finished units remain in the journal.
pub fn sweep(
    plan: &Plan,
    journal: Journal,
    motions: &[impl EvaluatedMotion],
    progress: impl Fn(usize) + Sync,
) -> Result<Summary, SweepError> {
    let missing: Vec<Unit> = plan.units().filter(|unit| !journal.has(*unit)).collect();
    let resumed = plan.units().count() - missing.len();
    let folder = journal.folder().to_path_buf();
    let journal = Mutex::new(journal);
    let job = |unit: &Unit| Job {
        motion: &motions[unit.clip],
        stream: unit.clip as u64,
        setup: &plan.cells[unit.cell].setup,
    };
    let jobs: Vec<Job<'_>> = missing.iter().map(job).collect();
    make_groups(&jobs, plan.seconds).into_par_iter().try_for_each(|group| {
        let units: Vec<Unit> = group.iter().map(|index| missing[*index]).collect();
        let of_group: Vec<Job<'_>> = group.iter().map(|index| jobs[*index]).collect();
        let add = |_: &Job<'_>, errors: &mut Errors, step: Step<'_>| errors.add_step(&step);
        for (unit, result) in units.iter().zip(track_together(&of_group, plan.seconds, add, |_| ()))
        {
            let outcome = match result {
                Ok(errors) => Outcome::Errors(errors),
                Err(error) => Outcome::Lost(error.to_string()),
            };
            journal.lock().expect("no thread panics with it").add(*unit, outcome)?;
            progress(count_steps(&motions[unit.clip], plan.seconds));
        }
        Ok::<_, SweepError>(())
    })?;
    let mut journal = journal.into_inner().expect("no thread panics with it");
    journal.sync()?;
    finish(plan, &journal, &folder, missing.len(), resumed)
}

/// Merges the journals of all shards and writes the tables of the whole sweep.
///
/// # Errors
/// [`SweepError`] if a shard is of another sweep, or units are in none of the shards.
pub fn merge(plan: &Plan, mut journal: Journal, shards: &[PathBuf]) -> Result<Summary, SweepError> {
    let mut taken = 0;
    for shard in shards {
        taken += journal.take_over(plan, shard)?;
    }
    journal.sync()?;
    let missing: Vec<Unit> = plan.units().filter(|unit| !journal.has(*unit)).collect();
    if let Some(first) = missing.first() {
        return Err(SweepError::Incomplete {
            missing: missing.len(),
            cell: first.cell,
            clip: plan.clips[first.clip].name.clone(),
        });
    }
    let folder = journal.folder().to_path_buf();
    finish(plan, &journal, &folder, 0, taken)
}

fn finish(
    plan: &Plan,
    journal: &Journal,
    folder: &Path,
    run: usize,
    resumed: usize,
) -> Result<Summary, SweepError> {
    let (files, mut ranking) = table::write(plan, journal, folder)?;
    // A cell of another shard may be better than a cell of this shard.
    let whole = if plan.shard == Shard::WHOLE { &ranking[..] } else { &[] };
    let fronts = pareto::fronts(
        whole.iter().map(|(cell, errors)| (*cell, &plan.cells[*cell].setup, *errors)),
    );
    ranking.sort_by(|(_, a), (_, b)| a.all.linear_mean_cm().total_cmp(&b.all.linear_mean_cm()));
    let cells = plan.shard_cells().count();
    let lost = cells - ranking.len();
    Ok(Summary { cells, run, resumed, lost, ranking, fronts, files })
}
