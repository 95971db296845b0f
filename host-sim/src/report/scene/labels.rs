//! Places for labels: beside what they name, on nothing else.

use core::f64::consts::PI;

use super::outline::Circle;
use super::stage::{STAGE_HEIGHT, STAGE_WIDTH};

/// A label in the picture.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::report) struct Label {
    /// What it says.
    pub(in crate::report) text: String,
    /// What it names.
    pub(in crate::report) named: (f64, f64),
    /// Left end and base line of the text.
    pub(in crate::report) place: (f64, f64),
    /// End of the line that leads from what is named to the text.
    pub(in crate::report) lead: (f64, f64),
}

/// Width of a letter, and height of a line with its margins.
const LETTER: f64 = 8.0;
const LINE: f64 = 20.0;
/// Free width around what is drawn, and distance to the edge of the stage.
const GAP: f64 = 5.0;
const EDGE: f64 = 10.0;
/// Top of the stage that its title takes.
const TITLE: f64 = 62.0;

#[derive(Debug, Clone, Copy)]
struct Rectangle {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Rectangle {
    fn nearest(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (x.clamp(self.left, self.right), y.clamp(self.top, self.bottom))
    }

    fn overlaps(&self, circle: &Circle) -> bool {
        let (x, y) = self.nearest((circle.x, circle.y));
        libm::hypot(x - circle.x, y - circle.y) < circle.r + GAP
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

/// Places every text near what it names: of the places around, the nearest that covers least of `drawn` and no
/// other label.
pub(super) fn place(texts: Vec<(String, (f64, f64))>, drawn: &[Circle]) -> Vec<Label> {
    let mut taken: Vec<Rectangle> = Vec::new();
    let mut labels = Vec::new();
    for (text, named) in texts {
        let width = LETTER * text.chars().count() as f64;
        let cost = |(rectangle, distance): &(Rectangle, f64)| {
            let covered = drawn.iter().filter(|circle| rectangle.overlaps(circle)).count();
            let met = taken.iter().filter(|other| rectangle.meets(other)).count();
            1e6 * met as f64 + 1e3 * covered as f64 + distance
        };
        let best = around(named, width).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let (rectangle, _) = best.expect("there are places around everything");
        taken.push(rectangle);
        labels.push(Label {
            text,
            named,
            place: (rectangle.left, rectangle.bottom - 5.5),
            lead: rectangle.nearest(named),
        });
    }
    labels
}

/// Rectangles for a label around a point, within the stage, with their distances.
fn around((x, y): (f64, f64), width: f64) -> impl Iterator<Item = (Rectangle, f64)> {
    const DIRECTIONS: u32 = 16;
    (1..=8).flat_map(move |ring| {
        let distance = 14.0 * f64::from(ring);
        (0..DIRECTIONS).map(move |index| {
            let (sin, cos) = libm::sincos(f64::from(index) * 2.0 * PI / f64::from(DIRECTIONS));
            let center_x = x + cos * (distance + 0.5 * width);
            let center_y = y + sin * (distance + 0.5 * LINE);
            let left = (center_x - 0.5 * width).clamp(EDGE, STAGE_WIDTH - EDGE - width);
            let top = (center_y - 0.5 * LINE).clamp(TITLE, STAGE_HEIGHT - EDGE - LINE);
            let rectangle = Rectangle { left, top, right: left + width, bottom: top + LINE };
            let (near_x, near_y) = rectangle.nearest((x, y));
            (rectangle, libm::hypot(near_x - x, near_y - y))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_cover_neither_what_is_drawn_nor_each_other() {
        let drawn: Vec<Circle> =
            (0..30).map(|i| Circle { x: 240.0, y: 100.0 + 10.0 * f64::from(i), r: 30.0 }).collect();
        let texts = (0..4).map(|i| (format!("label {i}"), (240.0, 200.0 + 5.0 * f64::from(i))));
        let labels = place(texts.collect(), &drawn);
        for (index, label) in labels.iter().enumerate() {
            let (left, base) = label.place;
            let right = left + LETTER * 7.0;
            assert!(right < 210.0 || left > 270.0, "{label:?}");
            for other in &labels[..index] {
                let apart = (other.place.1 - base).abs() >= LINE - 1e-9;
                assert!(apart || other.place.0 > right || other.place.0 + LETTER * 7.0 < left);
            }
        }
    }
}
