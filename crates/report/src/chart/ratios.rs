//! Charts of our means beside the paper's, both divided by Local's.

use maud::{Markup, html};
use sinew_evaluation::MethodName;

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart, horizontal_axis};
use super::legend::{class, marker};
use super::path::px;

const ROW: f64 = 26.0;

/// A row: the mean of one method over one group of joints, divided by Local's.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Ratio {
    pub(crate) method: MethodName,
    /// Name of the mean and of the joints, such as "angular, leaf".
    pub(crate) what: &'static str,
    pub(crate) ours: f64,
    /// The paper's value, if the paper has this figure.
    pub(crate) paper: Option<f64>,
}

/// Draws the ratios of one figure. Local is the line at 1; values on its left are better.
pub(crate) fn ratios(title: &str, rows: &[Ratio]) -> Markup {
    let height = 30.0 + ROW * rows.len() as f64 + 40.0;
    let frame = Frame { left: 180.0, top: 30.0, right: WIDTH - 14.0, bottom: height - 40.0 };
    let values = || rows.iter().flat_map(|row| [Some(row.ours), row.paper]).flatten();
    // The axis includes both sides of 1, with a margin.
    let low = values().fold(0.9, f64::min) * 0.93;
    let high = values().fold(1.1, f64::max) * 1.07;
    let axis = Axis::logarithmic([low, high], [frame.left, frame.right]);
    let texts: Vec<String> = rows
        .iter()
        .map(|row| format!("{} {}: {:.3}", row.method.label(), row.what, row.ours))
        .collect();
    let one = px(axis.at(1.0));
    chart(
        height,
        title,
        &texts.join(", "),
        &html! {
            (horizontal_axis(frame, &axis, "error divided by Local's, logarithmic"))
            line class="axis" x1=(one) x2=(one) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
            @for (index, row) in rows.iter().enumerate() {
                @let y = frame.top + ROW * (index as f64 + 0.5);
                text class="tick" x=(px(frame.left - 8.0)) y=(px(y + 4.0)) text-anchor="end" {
                    (short(row.method)) " " (row.what)
                }
                g class=(class(row.method)) {
                    @if let Some(paper) = row.paper {
                        line class="bar" x1=(px(axis.at(paper))) x2=(px(axis.at(row.ours))) y1=(px(y)) y2=(px(y)) {}
                        g class="paper" { (marker(row.method, axis.at(paper), y)) }
                    }
                    (marker(row.method, axis.at(row.ours), y))
                }
            }
        },
    )
}

const fn short(method: MethodName) -> &'static str {
    match method {
        MethodName::LinearCompensation => "Lin. comp.",
        MethodName::ManifoldProjection => "Projection",
        MethodName::ResolvedAcceleration => "Resolved",
        other => other.label(),
    }
}
