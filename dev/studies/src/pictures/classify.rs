//! Pictures of the study of nearest neighbours: the share of correct classifications, and the errors by group.

use std::io;
use std::path::{Path, PathBuf};

use maud::Markup;
use sinew_pose_metrics::spatial::{Measure, Metric};
use sinew_report::Grid;
use sinew_report::chart::{self, Interval, Row};
use sinew_report::file::write_all;

use crate::spatial::Summary;
use crate::spatial::classify::{self, LeaveOut, Plan, Study};

/// Writes the pictures into a folder, as SVG and PNG, and returns their paths.
///
/// # Errors
/// An I/O error.
pub fn write_classify(plan: &Plan<'_>, study: &Study, folder: &Path) -> io::Result<Vec<PathBuf>> {
    let pictures = [
        ("classify-rates".to_owned(), rates(plan, study)),
        ("classify-groups".to_owned(), groups(plan, study)),
    ];
    write_all(&pictures, folder)
}

/// Draws the share of poses that were classified correctly.
fn rates(plan: &Plan<'_>, study: &Study) -> Markup {
    let word = plan.classes.group_word();
    let kinds = [
        ("local", "by the nearest pose of another sequence".to_owned()),
        ("world", format!("by the nearest pose of another {word}")),
    ];
    let row = |measure: &Measure| {
        let of = |leave: &LeaveOut| {
            let summary = study.of(*measure, *leave)?.over_draws(|rates| rates.poses);
            summary.map(|summary| interval(&summary))
        };
        Row {
            label: measure.to_string(),
            intervals: LeaveOut::ALL.iter().map(of).collect(),
            paper: classify::paper(plan.classes, *measure),
        }
    };
    let rows: Vec<Row> = plan.measures.iter().map(row).collect();
    chart::intervals("Poses told right (%)", &kinds, &rows)
}

/// Converts a summary of shares to an interval in percent.
pub(super) fn interval(summary: &Summary) -> Interval {
    let [low, lower, _, upper, high] = summary.quantiles.map(|share| 100.0 * share);
    Interval { mean: 100.0 * summary.mean, middle: [lower, upper], ends: [low, high] }
}

/// Draws the share of each group's poses that were classified wrongly, for each class.
fn groups(plan: &Plan<'_>, study: &Study) -> Markup {
    let word = plan.classes.group_word();
    let columns: Vec<Measure> = Metric::ALL.into_iter().map(Measure::new).collect();
    let outcomes: Vec<_> = columns
        .iter()
        .filter_map(|measure| {
            let own = plan
                .measures
                .iter()
                .find(|own| (own.metric, own.weighting) == (measure.metric, measure.weighting))?;
            study.of(*own, LeaveOut::Group)
        })
        .collect();
    let (mut rows, mut cells) = (Vec::new(), Vec::new());
    for (index, class) in plan.classes.classes.into_iter().enumerate() {
        let of: Vec<_> =
            outcomes.iter().map(|outcome| outcome.of_groups(plan.classes, index)).collect();
        for (place, group) in plan.classes.groups(index).into_iter().enumerate() {
            rows.push(format!("{} {group}", class.name()));
            cells.extend(of.iter().map(|rates| rates[place].1.map(|rate| 100.0 * (1.0 - rate))));
        }
    }
    chart::heat_map(&Grid {
        title: format!("Poses told wrong by the nearest one of another {word} (%)"),
        condition: String::new(),
        row_name: format!("class and {word}"),
        column_name: "measure, all joints alike".to_owned(),
        rows,
        columns: outcomes.iter().map(|outcome| outcome.measure.to_string()).collect(),
        cells,
        range: (0.0, 100.0),
    })
}
