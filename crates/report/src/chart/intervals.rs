//! Charts of means with their spread, for several kinds per row.

use maud::{Markup, html};

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart, horizontal_axis};
use super::path::px;

/// Height of one kind's mark. The next constant is the space between two rows.
const MARK: f64 = 11.0;
const GAP: f64 = 9.0;
const KEY: f64 = 18.0;

/// A mean, and the spread of its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    pub mean: f64,
    /// Interval of the middle half of the values.
    pub middle: [f64; 2],
    /// Interval of the values without the outermost 5 % at each end.
    pub ends: [f64; 2],
}

/// A row of the chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub label: String,
    /// Intervals by kind.
    pub intervals: Vec<Option<Interval>>,
    /// The paper's value, if there is one.
    pub paper: Option<f64>,
}

/// Draws rows of intervals in percent, each kind with its class and label, and the paper's values as rings.
pub fn intervals(title: &str, kinds: &[(&str, String)], rows: &[Row]) -> Markup {
    let row = MARK * kinds.len() as f64 + GAP;
    let has_paper = rows.iter().any(|row| row.paper.is_some());
    let top = 30.0 + KEY * (kinds.len() + usize::from(has_paper)) as f64;
    let height = top + row * rows.len() as f64 + 40.0;
    let frame = Frame { left: 138.0, top, right: WIDTH - 14.0, bottom: height - 40.0 };
    let lowest = rows.iter().flat_map(|row| {
        let ends = row.intervals.iter().flatten().map(|interval| interval.ends[0]);
        ends.chain(row.paper)
    });
    // Rounded down to a multiple of ten, with the lowest value not on the end of the axis.
    let low = 10.0 * libm::floor(lowest.fold(100.0, f64::min) / 10.0 - 0.1);
    let axis = Axis::exact([low.max(0.0), 100.0], [frame.left, frame.right]);
    let texts = rows.iter().flat_map(|row| {
        let of_kind = |(interval, (_, kind)): (&Option<Interval>, &(&str, String))| {
            interval.map(|interval| format!("{}, {kind}: {:.1}", row.label, interval.mean))
        };
        row.intervals.iter().zip(kinds).filter_map(of_kind).collect::<Vec<_>>()
    });
    chart(
        height,
        title,
        &texts.collect::<Vec<_>>().join("; "),
        &html! {
            @for (index, (class, label)) in kinds.iter().enumerate() {
                @let y = 33.0 + KEY * index as f64;
                g class=(class) {
                    line class="bar" x1="10" x2="40" y1=(px(y)) y2=(px(y)) {}
                    circle class="marker" cx="25" cy=(px(y)) r="4" {}
                }
                text class="tick" x="48" y=(px(y + 4.0)) { (label) }
            }
            @if has_paper {
                @let y = 33.0 + KEY * kinds.len() as f64;
                circle class="ring" cx="25" cy=(px(y)) r="5" {}
                text class="tick" x="48" y=(px(y + 4.0)) { "the paper's figure" }
            }
            (horizontal_axis(frame, &axis, "mean; thick: half of all; thin: all but 5 % at either end"))
            @for (index, of) in rows.iter().enumerate() {
                @let middle = frame.top + row * (index as f64 + 0.5);
                text class="tick" x=(px(frame.left - 8.0)) y=(px(middle + 4.0)) text-anchor="end" { (of.label) }
                @for (kind, interval) in of.intervals.iter().enumerate() {
                    @let y = px(middle + MARK * (kind as f64 - 0.5 * (kinds.len() as f64 - 1.0)));
                    @if let Some(Interval { mean, middle: [lower, upper], ends: [low, high] }) = interval {
                        g class=(kinds[kind].0) {
                            line stroke-width="1.2" x1=(px(axis.at(*low))) x2=(px(axis.at(*high))) y1=(y) y2=(y) {}
                            line class="bar" x1=(px(axis.at(*lower))) x2=(px(axis.at(*upper))) y1=(y) y2=(y) {}
                            circle class="marker" cx=(px(axis.at(*mean))) cy=(y) r="4" {}
                        }
                    }
                }
                @if let Some(paper) = of.paper {
                    circle class="ring" cx=(px(axis.at(paper))) cy=(px(middle)) r="6" {}
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.left)) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
        },
    )
}
