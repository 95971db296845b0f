//! The summary of a sweep.

use std::path::PathBuf;

use super::pareto::ParetoFront;
use super::plan::Plan;
use crate::metrics::Errors;

/// The counts, the ranking and the fronts of a finished sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Number of cells of this shard.
    pub cells: usize,
    /// Number of units that were run now.
    pub run: usize,
    /// Number of units that were finished before: in the journal at the start, or in merged shards.
    pub resumed: usize,
    /// Number of cells whose figure was lost on at least one clip.
    pub lost: usize,
    /// All other cells with their errors over all clips, in increasing order of mean linear error.
    pub ranking: Vec<(usize, Errors)>,
    /// Fronts of mean linear error over mean angular error of all joints, for each task with several cells; empty
    /// for a shard.
    pub fronts: Vec<ParetoFront>,
    /// Paths of the tables.
    pub files: Vec<PathBuf>,
}

impl Summary {
    /// Writes the summary in words: counts, fronts, both ends of the ranking, and the tables' paths.
    pub fn text(&self, plan: &Plan) -> String {
        let Summary { cells, run, resumed, lost, ranking, fronts, files } = self;
        let mut lines = vec![format!("{cells} cells; {run} runs made, {resumed} taken over")];
        if *lost > 0 {
            lines.push(format!("the figure was lost in {lost} cells"));
        }
        let own = own_settings(plan);
        if !fronts.is_empty() {
            lines.push("front of mean linear over mean angular error of all joints:".to_owned());
            lines.extend(fronts.iter().take(FRONTS).flat_map(|front| list_front(front, &own)));
            if fronts.len() > FRONTS {
                lines.push(format!("  and of {} more tasks, see on_front", fronts.len() - FRONTS));
            }
        }
        if ranking.len() > 1 {
            lines.push("mean linear error of all bodies, smallest and largest:".to_owned());
            lines.extend(list_extremes(ranking, &own));
        }
        lines.extend(files.iter().map(|file| file.display().to_string()));
        lines.push(String::new());
        lines.join("\n")
    }
}

/// Number of cells that are shown from each end of the ranking.
const SHOWN: usize = 3;

/// Number of fronts that are shown. The next constant is the number of cells of each front.
const FRONTS: usize = 8;
const FRONT_CELLS: usize = 20;

/// Lists, for every cell, the settings that are not common to all cells.
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

/// Lists the task of a front, and its cells.
fn list_front(front: &ParetoFront, own: &[Vec<String>]) -> Vec<String> {
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

/// Lists the first and last cells of a ranking.
fn list_extremes(ranking: &[(usize, Errors)], own: &[Vec<String>]) -> Vec<String> {
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
