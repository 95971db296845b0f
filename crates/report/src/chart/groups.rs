//! Charts with a bar for each of several kinds, in groups of joints.

use maud::{Markup, html};

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart, horizontal_axis};
use super::path::px;

const BAR: f64 = 7.0;
/// Space between two groups.
const GAP: f64 = 10.0;
const KEY: f64 = 20.0;

/// Kinds of bars: CSS class and label of each.
pub type Kinds<'a> = &'a [(&'a str, &'a str)];

/// Draws the values of all kinds by group. A missing value has no bar.
pub fn groups(
    title: &str,
    unit: &str,
    kinds: Kinds<'_>,
    rows: &[(&str, Vec<Option<f64>>)],
) -> Markup {
    let row = BAR * kinds.len() as f64 + GAP;
    let top = 30.0 + KEY;
    let height = top + row * rows.len() as f64 + 40.0;
    let frame = Frame { left: 60.0, top, right: WIDTH - 14.0, bottom: height - 40.0 };
    let values = rows.iter().flat_map(|(name, values)| values.iter().map(move |v| (*name, *v)));
    let (worst, largest) = values
        .filter_map(|(name, value)| Some((name, value?)))
        .fold(("", 0.0), |worst, one| if one.1 > worst.1 { one } else { worst });
    let axis = Axis::from_zero(largest, [frame.left, frame.right]);
    let key_width = (WIDTH - 20.0) / kinds.len() as f64;
    chart(
        height,
        title,
        &format!("The largest is that of {worst}: {largest:.2} {unit}"),
        &html! {
            @for (index, (class, label)) in kinds.iter().enumerate() {
                @let x = 10.0 + key_width * index as f64;
                g class=(class) {
                    line class="bar wide" x1=(px(x)) x2=(px(x + 16.0)) y1="36" y2="36" {}
                }
                text class="tick" x=(px(x + 21.0)) y="40" { (label) }
            }
            (horizontal_axis(frame, &axis, unit))
            @for (index, (name, values)) in rows.iter().enumerate() {
                @let middle = frame.top + row * (index as f64 + 0.5);
                text class="tick" x=(px(frame.left - 8.0)) y=(px(middle + 4.0)) text-anchor="end" { (name) }
                @for (kind, value) in values.iter().enumerate() {
                    @let y = middle + BAR * (kind as f64 - 0.5 * (kinds.len() as f64 - 1.0));
                    @if let Some(value) = value {
                        g class=(kinds[kind].0) {
                            line class="bar wide" x1=(px(frame.left)) x2=(px(axis.at(*value))) y1=(px(y)) y2=(px(y)) {}
                        }
                    }
                }
            }
            line class="axis" x1=(px(frame.left)) x2=(px(frame.left)) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
        },
    )
}
