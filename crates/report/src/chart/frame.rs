//! The frame of a chart: title, axes, and the rectangle between them.

use maud::{Markup, html};

use super::axis::Axis;
use super::path::px;

/// Width of a chart. Two charts fit beside each other on a wide page, and one chart fits on a narrow page; both
/// are readable.
pub(crate) const WIDTH: f64 = 480.0;

/// The rectangle between the axes, in the chart's units.
#[derive(Debug, Clone, Copy)]
pub(super) struct Frame {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Frame {
    /// Creates a frame with room for a title above, numbers on the left, and numbers and a name below.
    pub(super) const fn of_height(height: f64, left: f64) -> Self {
        Self { left, top: 30.0, right: WIDTH - 14.0, bottom: height - 40.0 }
    }
}

/// Returns a whole chart with its title, and a description for people who cannot see it.
pub(super) fn chart(height: f64, title: &str, description: &str, content: &Markup) -> Markup {
    html! {
        svg xmlns="http://www.w3.org/2000/svg" class="chart" role="img"
            viewBox={ "0 0 " (px(WIDTH)) " " (px(height)) } aria-label={ (title) ". " (description) } {
            text class="chart-title" x="2" y="15" { (title) }
            (content)
        }
    }
}

/// Draws grid lines, numbers and the name of the horizontal axis.
pub(super) fn horizontal_axis(frame: Frame, axis: &Axis, name: &str) -> Markup {
    html! {
        @for (value, label) in axis.ticks() {
            @let x = px(axis.at(value));
            line class="grid" x1=(x) x2=(x) y1=(px(frame.top)) y2=(px(frame.bottom)) {}
            text class="tick" x=(x) y=(px(frame.bottom + 15.0)) text-anchor="middle" { (label) }
        }
        text class="axis-name" x=(px(frame.right)) y=(px(frame.bottom + 32.0)) text-anchor="end" { (name) }
    }
}

/// Draws grid lines and numbers of the vertical axis.
pub(super) fn vertical_axis(frame: Frame, axis: &Axis) -> Markup {
    html! {
        @for (value, label) in axis.ticks() {
            @let y = axis.at(value);
            line class="grid" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(y)) y2=(px(y)) {}
            text class="tick" x=(px(frame.left - 6.0)) y=(px(y + 4.0)) text-anchor="end" { (label) }
        }
    }
}
