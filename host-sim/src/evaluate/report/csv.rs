//! The result as CSV.

use serde::Serialize;

use super::super::{Errors, Evaluation, MethodName, WeightedTotals};

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
    /// Of whole poses: the leaves have none.
    weighted_mean_cm: Option<f64>,
    weighted_max_cm: Option<f64>,
}

/// One row per scale, method and group of joints, over all clips.
pub fn result_csv(evaluation: &Evaluation) -> String {
    let mut rows = Vec::new();
    for figure in &evaluation.figures {
        for result in &figure.methods {
            rows.extend(both(None, figure.scale, result.method, &result.total));
        }
    }
    text(&rows)
}

/// The same for every single clip.
pub fn clips_csv(evaluation: &Evaluation) -> String {
    let mut rows = Vec::new();
    for figure in &evaluation.figures {
        for result in &figure.methods {
            for (clip, errors) in evaluation.clips.iter().zip(&result.clips) {
                rows.extend(both(Some(&clip.name), figure.scale, result.method, errors));
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
) -> [Row<'a>; 2] {
    let weighted = Some(&errors.weighted);
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
