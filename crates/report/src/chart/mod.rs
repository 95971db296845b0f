//! Charts as SVG. Colours come from classes and `assets/chart.css`, so that one picture serves a light and a
//! dark page, and a file of its own.

mod axis;
mod course;
mod distribution;
mod groups;
mod heat_map;
mod histogram;
mod intervals;
mod joints;
mod legend;
mod pareto;
mod plane;
mod ratios;
mod strips;

use std::fmt::Write as _;

use maud::{Markup, html};
use sinew_evaluation::ErrorTotals;

pub(super) use axis::Axis;
pub(super) use course::{Statistic, course};
pub(super) use distribution::distribution;
pub use groups::{Kinds, groups};
pub use heat_map::heat_map;
pub use histogram::{Histograms, Panel};
pub use intervals::{Interval, Row, intervals};
pub(super) use joints::{ROW, joints, room};
pub(super) use legend::{legend, legend_lines};
pub(super) use pareto::{Joined, ParetoChart, Reference, Spot};
pub use plane::{Plane, planes};
pub(super) use ratios::{Ratio, ratios};
pub use strips::{Pair, strips};

/// Width of a chart: two stand side by side on a wide page, one fills a narrow one, both readable.
pub(super) const WIDTH: f64 = 480.0;

/// What an error is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Quantity {
    /// Angles, in degrees.
    Angular,
    /// Distances, in centimetres.
    Linear,
}

impl Quantity {
    pub(super) const BOTH: [Self; 2] = [Self::Angular, Self::Linear];

    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::Angular => "angular",
            Self::Linear => "linear",
        }
    }

    pub(super) const fn unit(self) -> &'static str {
        match self {
            Self::Angular => "°",
            Self::Linear => "cm",
        }
    }

    fn mean(self, totals: &ErrorTotals) -> f64 {
        match self {
            Self::Angular => totals.angular_mean_deg(),
            Self::Linear => totals.linear_mean_cm(),
        }
    }

    fn max(self, totals: &ErrorTotals) -> f64 {
        match self {
            Self::Angular => totals.angular_max_deg(),
            Self::Linear => totals.linear_max_cm(),
        }
    }
}

/// The rectangle between the axes, in the chart's units.
#[derive(Debug, Clone, Copy)]
struct Frame {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Frame {
    /// Room for a title above, numbers left and numbers and a name below.
    const fn of_height(height: f64, left: f64) -> Self {
        Self { left, top: 30.0, right: WIDTH - 14.0, bottom: height - 40.0 }
    }
}

/// A whole chart: its title, and a description for those who cannot see it.
fn chart(height: f64, title: &str, description: &str, content: &Markup) -> Markup {
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart" role="img"
            viewBox={ "0 0 " (px(WIDTH)) " " (px(height)) } aria-label={ (title) ". " (description) } {
            text class="chart-title" x="2" y="15" { (title) }
            (content)
        }
    }
}

/// Grid lines, numbers and name of the horizontal axis.
fn horizontal_axis(frame: Frame, axis: &Axis, name: &str) -> Markup {
    html! {
        @for (value, label) in axis.ticks() {
            @let x = px(axis.at(value));
            line class="grid" x1=(x) x2=(x) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
            text class="tick" x=(x) y=(px(frame.bottom + 15.0)) text-anchor="middle" { (label) }
        }
        text class="axis-name" x=(px(frame.right)) y=(px(frame.bottom + 32.0)) text-anchor="end" { (name) }
    }
}

/// Grid lines and numbers of the vertical axis.
fn vertical_axis(frame: Frame, axis: &Axis) -> Markup {
    html! {
        @for (value, label) in axis.ticks() {
            @let y = axis.at(value);
            line class="grid" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(y)) y2=(px(y)) {}
            text class="tick" x=(px(frame.left - 6.0)) y=(px(y + 4.0)) text-anchor="end" { (label) }
        }
    }
}

/// Path data of a line through points.
pub(super) fn line(points: impl IntoIterator<Item = (f64, f64)>) -> String {
    let mut data = String::new();
    for (index, (x, y)) in points.into_iter().enumerate() {
        let command = if index == 0 { 'M' } else { 'L' };
        write!(data, "{command}{} {}", px(x), px(y)).expect("a string takes everything");
    }
    data
}

/// A coordinate to a tenth: finer than can be seen, and the same text on every machine.
pub fn px(x: f64) -> String {
    let text = format!("{x:.1}");
    let short = text.strip_suffix(".0").unwrap_or(&text);
    if short == "-0" { "0".into() } else { short.into() }
}
