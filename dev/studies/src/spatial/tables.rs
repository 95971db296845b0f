//! Output that both studies of two classes share.

use comfy_table::Table;
use sinew_pose_metrics::spatial::{Measure, SpatialRig};

use super::classes::TwoClasses;
use super::sign_test;
use super::summary::Summary;
use crate::tables::aligned;

/// Makes a table of these rows. The first column has text, and the others numbers.
pub(super) fn table(header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> Table {
    let mut table = crate::tables::table(header.iter().copied());
    for row in rows {
        table.add_row(row);
    }
    aligned(table)
}

/// Describes the classes, the rig and the measures.
pub(super) fn about(classes: &TwoClasses, rig: &SpatialRig, measures: &[Measure]) -> String {
    let of_class = |class: usize| {
        let members = classes.members(class);
        let poses: usize = members.iter().map(|own| classes.sequences[*own].frames.len()).sum();
        let groups = classes.groups(class).len();
        format!(
            "{}: {} sequences, {poses} poses, {}",
            classes.classes[class].name(),
            members.len(),
            count(groups, classes.group_word()),
        )
    };
    let lines = measures.first().map_or(0, |measure| measure.steps);
    format!(
        "{}; {}\n{} joints, seen from {}; lines in {}\n",
        of_class(0),
        of_class(1),
        classes.skeleton.joints.len(),
        rig.joint(0),
        count(usize::from(lines), "step"),
    )
}

fn count(number: usize, word: &str) -> String {
    if number == 1 { format!("1 {word}") } else { format!("{number} {word}s") }
}

/// Differences of values, in percentage points, and the numbers of larger and smaller ones.
pub(super) struct Difference {
    pub(super) summary: Option<Summary>,
    pub(super) more: usize,
    pub(super) less: usize,
    pub(super) count: usize,
}

impl Difference {
    pub(super) fn of(pairs: impl IntoIterator<Item = (f64, f64)>) -> Self {
        let values: Vec<f64> = pairs.into_iter().map(|(value, base)| value - base).collect();
        // Rates of the same poses: differences below rounding do not count.
        let more = values.iter().filter(|difference| **difference > 1e-12).count();
        let less = values.iter().filter(|difference| **difference < -1e-12).count();
        Self { summary: Summary::of(&values), more, less, count: values.len() }
    }

    pub(super) fn mean(&self) -> String {
        self.summary.map_or_else(String::new, |summary| {
            format!("{:+.1} ± {:.1}", 100.0 * summary.mean, 100.0 * summary.deviation)
        })
    }

    pub(super) fn how_often(&self) -> String {
        format!("{} : {}", self.more, self.less)
    }

    /// Formats the probability by the sign test.
    pub(super) fn p(&self) -> String {
        match sign_test::p(self.more, self.less) {
            small if small < 1e-6 => "< 1e-6".to_owned(),
            small if small < 1e-3 => format!("{small:.0e}"),
            p => format!("{p:.3}"),
        }
    }
}
