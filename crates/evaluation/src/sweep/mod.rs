//! Sweeps: many setups on many clips, in parallel, over many machines, and without losing what is done.
//!
//! A sweep file holds grids of values; each combination is a cell, a [`Setup`](crate::Setup) of its own.
//! What is run is a unit: one cell on one clip. Every finished unit goes to a journal at once, so that a
//! sweep that was killed resumes; the tables are written from the journal when it is complete,
//! and are the same bytes however it came about.

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

use crate::motion::{EvaluatedMotion, count_steps};
use crate::run::Run;

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

/// Runs what the journal lacks, then writes the tables beside it. `progress` gets the number of steps
/// done, now and then.
///
/// # Errors
/// [`SweepError`] if the journal or a table cannot be written; what is finished stays in the journal.
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
    missing.par_iter().try_for_each(|unit| {
        let motion = &motions[unit.clip];
        let setup = &plan.cells[unit.cell].setup;
        let run = Run::new(motion, setup, plan.seconds, unit.clip as u64);
        let outcome = match run.and_then(Run::measure) {
            Ok((errors, _)) => Outcome::Errors(errors),
            Err(error) => Outcome::Lost(error.to_string()),
        };
        journal.lock().expect("no thread panics with it").add(*unit, outcome)?;
        progress(count_steps(motion, plan.seconds));
        Ok::<_, SweepError>(())
    })?;
    let mut journal = journal.into_inner().expect("no thread panics with it");
    journal.sync()?;
    finish(plan, &journal, &folder, missing.len(), resumed)
}

/// Puts the journals of all shards together and writes the tables of the whole.
///
/// # Errors
/// [`SweepError`] if a shard is of another sweep, or units are in none of them.
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
    // A cell may be bettered by one of another shard.
    let whole = if plan.shard == Shard::WHOLE { &ranking[..] } else { &[] };
    let fronts = pareto::fronts(
        whole.iter().map(|(cell, errors)| (*cell, &plan.cells[*cell].setup, *errors)),
    );
    ranking.sort_by(|(_, a), (_, b)| a.all.linear_mean_cm().total_cmp(&b.all.linear_mean_cm()));
    let cells = plan.shard_cells().count();
    let lost = cells - ranking.len();
    Ok(Summary { cells, run, resumed, lost, ranking, fronts, files })
}
