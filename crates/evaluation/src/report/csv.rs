//! Writes the result as CSV.

use serde::Serialize;

use super::super::{Errors, Evaluation, Likeness, MethodName, WeightedTotals};

#[derive(Serialize)]
struct Row<'a> {
    #[serde(skip_serializing_if = "Option::is_none")]
    clip: Option<&'a str>,
    scale: f64,
    method: MethodName,
    joints: &'static str,
    n: u64,
    angular_mean_deg: f64,
    linear_mean_cm: f64,
    angular_max_deg: f64,
    linear_max_cm: f64,
    /// Errors of whole poses; rows of leaves have none.
    weighted_mean_cm: Option<f64>,
    weighted_max_cm: Option<f64>,
    /// Angles between a rig and the performers of its clips, for all limbs, not for leaves. Other evaluations do
    /// not have these columns.
    #[serde(skip_serializing_if = "Option::is_none")]
    retargeting_mean_deg: Option<Cell>,
    #[serde(skip_serializing_if = "Option::is_none")]
    total_mean_deg: Option<Cell>,
}

/// A cell of a column that not every table has. It is empty if the row has no number for it.
#[derive(Serialize)]
struct Cell(Option<f64>);

/// Returns one row per scale, method and group of joints, over all clips.
pub fn result_csv(evaluation: &Evaluation) -> String {
    let mut rows = Vec::new();
    for figure in &evaluation.figures {
        for result in &figure.methods {
            rows.extend(both(None, figure.scale, result.method, &result.total, result.likeness()));
        }
    }
    text(&rows)
}

/// Returns one row per clip, scale, method and group of joints.
pub fn clips_csv(evaluation: &Evaluation) -> String {
    let mut rows = Vec::new();
    for figure in &evaluation.figures {
        for result in &figure.methods {
            let of_clips = result.clips.iter().zip(&result.likeness);
            for (clip, (errors, likeness)) in evaluation.clips.iter().zip(of_clips) {
                let likeness = (!likeness.total.is_empty()).then_some(*likeness);
                rows.extend(both(Some(&clip.name), figure.scale, result.method, errors, likeness));
            }
        }
    }
    text(&rows)
}

fn both<'a>(
    clip: Option<&'a str>,
    scale: f64,
    method: MethodName,
    errors: &Errors,
    likeness: Option<Likeness>,
) -> [Row<'a>; 2] {
    let weighted = Some(&errors.weighted);
    let of_limbs = |of: fn(&Likeness) -> f64, is_all: bool| {
        likeness.map(|likeness| Cell(is_all.then(|| of(&likeness))))
    };
    [("all", &errors.all, weighted), ("leaf", &errors.leaf, None)].map(
        |(joints, totals, weighted)| Row {
            clip,
            scale,
            method,
            joints,
            n: totals.n,
            angular_mean_deg: totals.angular_mean_deg(),
            linear_mean_cm: totals.linear_mean_cm(),
            angular_max_deg: totals.angular_max_deg(),
            linear_max_cm: totals.linear_max_cm(),
            weighted_mean_cm: weighted.map(WeightedTotals::mean_cm),
            weighted_max_cm: weighted.map(WeightedTotals::max_cm),
            retargeting_mean_deg: of_limbs(|l| l.retargeting.mean_deg(), weighted.is_some()),
            total_mean_deg: of_limbs(|l| l.total.mean_deg(), weighted.is_some()),
        },
    )
}

fn text(rows: &[Row<'_>]) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for row in rows {
        writer.serialize(row).expect("memory takes everything");
    }
    let bytes = writer.into_inner().expect("memory takes everything");
    String::from_utf8(bytes).expect("CSV of text is text")
}
