//! Charts of paths in the plane: the first two components of two embeddings, beside each other.

use maud::{Markup, html};

use super::axis::Axis;
use super::frame::{Frame, WIDTH, chart};
use super::path::{line, px};

/// Width and height of a panel.
const SIDE: f64 = 222.0;
const TOP: f64 = 74.0;

/// The positions of several items over time.
#[derive(Debug, Clone, PartialEq)]
pub struct Plane {
    pub title: String,
    /// Text below the title.
    pub subtitle: String,
    /// Path of each item.
    pub ways: Vec<Vec<[f64; 2]>>,
}

/// Draws two planes side by side. `things` contains the CSS class and the name of each item.
pub fn planes(title: &str, things: &[(&str, &str)], planes: &[Plane; 2]) -> Markup {
    let height = TOP + SIDE + 10.0;
    let key_width = (WIDTH - 20.0) / things.len() as f64;
    let texts: Vec<String> =
        planes.iter().map(|plane| format!("{}: {}", plane.title, plane.subtitle)).collect();
    chart(
        height,
        title,
        &texts.join("; "),
        &html! {
            @for (index, (class, label)) in things.iter().enumerate() {
                @let left = 10.0 + key_width * index as f64;
                g class=(class) { circle class="marker" cx=(px(left)) cy="31" r="4" {} }
                text class="tick" x=(px(left + 9.0)) y="35" { (label) }
            }
            @for (index, plane) in planes.iter().enumerate() {
                @let left = 10.0 + (SIDE + 16.0) * index as f64;
                (plane.draw(things, Frame { left, top: TOP, right: left + SIDE, bottom: TOP + SIDE }))
            }
        },
    )
}

impl Plane {
    /// Draws a square plane with equal units on both axes.
    fn draw(&self, things: &[(&str, &str)], frame: Frame) -> Markup {
        let all = || self.ways.iter().flatten();
        let ends = |axis: usize| {
            let low = all().map(|place| place[axis]).fold(f64::INFINITY, f64::min);
            let high = all().map(|place| place[axis]).fold(f64::NEG_INFINITY, f64::max);
            (low, high)
        };
        let spans = [ends(0), ends(1)];
        let half = spans.iter().map(|(low, high)| 0.54 * (high - low)).fold(1e-9, f64::max);
        let around =
            |(low, high): (f64, f64)| [0.5 * (low + high) - half, 0.5 * (low + high) + half];
        let x = Axis::exact(around(spans[0]), [frame.left, frame.right]);
        let y = Axis::exact(around(spans[1]), [frame.bottom, frame.top]);
        html! {
            text class="axis-name" x=(px(frame.left)) y=(px(frame.top - 23.0)) { (self.title) }
            text class="tick" x=(px(frame.left)) y=(px(frame.top - 7.0)) { (self.subtitle) }
            rect class="frame" x=(px(frame.left)) y=(px(frame.top)) width=(px(frame.right - frame.left)) height=(px(frame.bottom - frame.top)) {}
            @for ((class, _), way) in things.iter().zip(&self.ways) {
                g class=(class) {
                    path class="stroke way" d=(line(way.iter().map(|place| (x.at(place[0]), y.at(place[1]))))) {}
                    @for place in way {
                        circle class="marker" cx=(px(x.at(place[0]))) cy=(px(y.at(place[1]))) r="2.6" {}
                    }
                }
            }
        }
    }
}
