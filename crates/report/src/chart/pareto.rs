//! Charts of mean linear error over mean angular error: the price of a gain in one error.

use maud::{Markup, html};
use sinew_evaluation::MethodName;

use super::axis::Axis;
use super::frame::{Frame, chart, horizontal_axis, vertical_axis};
use super::legend::{class, marker};
use super::path::{line, px};
use crate::labels::{self, Circle, Ground, Label, Rectangle};

/// Height of the field between the axes. The next constant is the height of a line above it.
const FIELD: f64 = 256.0;
const LINE: f64 = 18.0;

/// A mean angular error in degrees and a mean linear error in centimetres.
pub(crate) type Means = [f64; 2];

/// A chart of mean linear error over mean angular error.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ParetoChart {
    pub(crate) title: String,
    /// Conditions that all results share, on a separate line.
    pub(crate) condition: String,
    pub(crate) spots: Vec<Spot>,
    /// Spots of one method that differ in one value, joined by a line.
    pub(crate) joined: Vec<Joined>,
    /// Curves for comparison.
    pub(crate) references: Vec<Reference>,
}

/// A result in the chart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Spot {
    /// Method whose colour and marker the spot has; `None` for a neutral one.
    pub(crate) method: Option<MethodName>,
    /// Description of the result, for people who cannot see it.
    pub(crate) name: String,
    /// Text beside the spot, if there is any.
    pub(crate) label: Option<String>,
    pub(crate) means: Means,
    pub(crate) on_front: bool,
}

/// Results that are joined by a line.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Joined {
    pub(crate) method: Option<MethodName>,
    pub(crate) means: Vec<Means>,
}

/// A curve for comparison, and its name in the key.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Reference {
    pub(crate) name: &'static str,
    pub(crate) dashed: bool,
    pub(crate) means: Vec<Means>,
    /// Texts beside some points of the line.
    pub(crate) labels: Vec<(String, Means)>,
}

impl ParetoChart {
    /// Draws the chart. Points nearer to the origin are better.
    pub(crate) fn draw(&self) -> Markup {
        let lines = if self.condition.is_empty() { 2.0 } else { 3.0 };
        let top = 16.0 + LINE * lines;
        let height = top + FIELD + 40.0;
        let frame = Frame { top, ..Frame::of_height(height, 44.0) };
        let shown = || {
            let references = self.references.iter().flat_map(|reference| &reference.means);
            self.spots.iter().map(|spot| &spot.means).chain(references)
        };
        let largest = |error: usize| shown().map(|means| means[error]).fold(0.0, f64::max);
        let least = shown().map(|means| means[1]).fold(f64::INFINITY, f64::min);
        let axes = [
            Axis::from_zero(largest(0), [frame.left, frame.right]),
            Axis::around([least, largest(1)], [frame.bottom, frame.top]),
        ];
        let at = |[angular, linear]: &Means| (axes[0].at(*angular), axes[1].at(*linear));
        let labels = self.labels(frame, at);
        chart(
            height,
            &self.title,
            &self.description(),
            &html! {
                text class="axis-name" x="2" y="34" { (self.condition) }
                (self.key(top - LINE))
                (vertical_axis(frame, &axes[1]))
                (horizontal_axis(frame, &axes[0], "mean angular error of all joints (°)"))
                line class="axis" x1=(px(frame.left)) x2=(px(frame.right)) y1=(px(frame.bottom)) y2=(px(frame.bottom)) {}
                @for reference in &self.references {
                    g class=(reference.class()) {
                        path class="stroke" d=(line(reference.means.iter().map(at))) {}
                        @for (_, means) in &reference.labels {
                            circle class="marker" cx=(px(at(means).0)) cy=(px(at(means).1)) r="2.4" {}
                        }
                    }
                }
                @for joined in &self.joined {
                    g class=(looks(joined.method)) { path class="stroke thin" d=(line(joined.means.iter().map(at))) {} }
                }
                @for label in &labels {
                    @let (from, to) = (label.lead, label.named);
                    // A text directly beside its marker needs no line.
                    @if libm::hypot(from.0 - to.0, from.1 - to.1) > NEAR {
                        path class="lead" d=(line([from, to])) {}
                    }
                }
                @for spot in &self.spots {
                    @let (x, y) = at(&spot.means);
                    @if spot.on_front { circle class="ring" cx=(px(x)) cy=(px(y)) r=(px(RING)) {} }
                    g class=(looks(spot.method)) {
                        @match spot.method {
                            Some(method) => (marker(method, x, y)),
                            None => circle class="marker" cx=(px(x)) cy=(px(y)) r="3" {},
                        }
                    }
                }
                @for label in &labels {
                    // A text on the left of its marker ends beside the marker.
                    @let (x, anchor) = if label.lead.0 < label.named.0 { (label.lead.0, "end") } else { (label.place.0, "start") };
                    @for (index, line) in label.text.lines().enumerate() {
                        text class="tick" x=(px(x)) text-anchor=(anchor) y=(px(label.place.1 + LABEL_LINE * index as f64)) { (line) }
                    }
                }
            },
        )
    }

    /// Places the texts beside spots and references, in this order, to give the spots the better places. Spots
    /// that cannot be distinguished share one text.
    fn labels(&self, frame: Frame, at: impl Fn(&Means) -> (f64, f64)) -> Vec<Label> {
        let mut texts: Vec<(String, (f64, f64))> = Vec::new();
        for spot in &self.spots {
            let Some(label) = &spot.label else { continue };
            let (x, y) = at(&spot.means);
            let near =
                texts.iter_mut().find(|(_, other)| libm::hypot(other.0 - x, other.1 - y) < RING);
            match near {
                Some((text, _)) => *text = format!("{text}\n{label}"),
                None => texts.push((label.clone(), (x, y))),
            }
        }
        let of_references = self.references.iter().flat_map(|reference| &reference.labels);
        texts.extend(of_references.map(|(text, means)| (text.clone(), at(means))));
        let mut drawn: Vec<Circle> = Vec::new();
        for spot in &self.spots {
            let (x, y) = at(&spot.means);
            drawn.push(Circle { x, y, r: if spot.on_front { RING } else { 5.0 } });
        }
        let references = self.references.iter().map(|reference| &reference.means);
        for means in references.chain(self.joined.iter().map(|joined| &joined.means)) {
            let points: Vec<(f64, f64)> = means.iter().map(&at).collect();
            drawn.extend(points.windows(2).flat_map(|pair| along(pair[0], pair[1])));
        }
        let bounds = Rectangle {
            left: frame.left + 3.0,
            top: frame.top,
            right: frame.right,
            bottom: frame.bottom - 2.0,
        };
        let ground = Ground { bounds, letter: 6.8, line: LABEL_LINE, below: 3.5, gap: 1.0 };
        labels::place(texts, &drawn, &ground)
    }

    fn key(&self, y: f64) -> Markup {
        let mut left = 2.0;
        let mut next = |sample: f64, name: &str| {
            let at = left;
            left += sample + 16.0 + 7.0 * name.chars().count() as f64;
            at
        };
        let ring = "on the front";
        html! {
            @if self.spots.iter().any(|spot| spot.on_front) {
                @let x = next(14.0, ring);
                circle class="ring" cx=(px(x + 7.0)) cy=(px(y)) r="6" {}
                text class="tick" x=(px(x + 20.0)) y=(px(y + 4.0)) { (ring) }
            }
            @for reference in &self.references {
                @let x = next(26.0, reference.name);
                g class=(reference.class()) { path class="stroke" d={ "M" (px(x)) " " (px(y)) "l26 0" } {} }
                text class="tick" x=(px(x + 32.0)) y=(px(y + 4.0)) { (reference.name) }
            }
        }
    }

    fn description(&self) -> String {
        let spots: Vec<String> = self
            .spots
            .iter()
            .map(|spot| {
                let [angular, linear] = spot.means;
                let front = if spot.on_front { ", on the front" } else { "" };
                format!("{}: {angular:.2}° and {linear:.2} cm{front}", spot.name)
            })
            .collect();
        let spots = spots.join("; ");
        if self.condition.is_empty() { spots } else { format!("{}. {spots}", self.condition) }
    }
}

/// Height of a line of a label.
const LABEL_LINE: f64 = 14.0;

/// Radius of the ring around a point on the front. The next constant is the maximum distance of a label without a
/// line.
const RING: f64 = 8.0;
const NEAR: f64 = 13.0;

impl Reference {
    fn class(&self) -> &'static str {
        if self.dashed { "reference dashed" } else { "reference" }
    }
}

fn looks(method: Option<MethodName>) -> String {
    method.map_or_else(|| "method".to_owned(), class)
}

/// Returns circles that cover a line.
fn along(a: (f64, f64), b: (f64, f64)) -> impl Iterator<Item = Circle> {
    const COUNT: u32 = 16;
    (1..=COUNT).map(move |index| {
        let share = f64::from(index) / f64::from(COUNT);
        Circle { x: a.0 + share * (b.0 - a.0), y: a.1 + share * (b.1 - a.1), r: 2.0 }
    })
}
