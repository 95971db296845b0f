//! Places labels near the points that they name, without overlaps.

use core::f64::consts::PI;

/// A label in the picture.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Label {
    /// Text of one or more lines.
    pub(super) text: String,
    /// Point that the label names.
    pub(super) named: (f64, f64),
    /// Left end of the first line's base line.
    pub(super) place: (f64, f64),
    /// End, at the text, of the line from the named point.
    pub(super) lead: (f64, f64),
}

/// The region for labels, and their dimensions.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground {
    /// Rectangle that contains all labels.
    pub(super) bounds: Rectangle,
    /// Width of a letter.
    pub(super) letter: f64,
    /// Height of a line with its margins. The next field is the part below the base line.
    pub(super) line: f64,
    pub(super) below: f64,
    /// Free width around drawn objects.
    pub(super) gap: f64,
}

/// A circle in the plane of the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Circle {
    pub(super) x: f64,
    pub(super) y: f64,
    pub(super) r: f64,
}

/// A rectangle in the plane of the picture. y points down.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub(super) left: f64,
    pub(super) top: f64,
    pub(super) right: f64,
    pub(super) bottom: f64,
}

impl Rectangle {
    fn nearest(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (x.clamp(self.left, self.right), y.clamp(self.top, self.bottom))
    }

    fn overlaps(&self, circle: &Circle, gap: f64) -> bool {
        let (x, y) = self.nearest((circle.x, circle.y));
        libm::hypot(x - circle.x, y - circle.y) < circle.r + gap
    }

    /// Returns whether a line crosses the rectangle, tested at `POINTS` points of the line.
    fn is_crossed(&self, from: (f64, f64), to: (f64, f64)) -> bool {
        const POINTS: u32 = 16;
        (1..POINTS).any(|index| {
            let share = f64::from(index) / f64::from(POINTS);
            let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
            self.left < at.0 && at.0 < self.right && self.top < at.1 && at.1 < self.bottom
        })
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

/// Places every text near the point that it names. In order of importance: it covers no other label, no line from a
/// point to its label crosses a label, it covers little of `drawn`, and it is near.
pub(super) fn place(
    texts: Vec<(String, (f64, f64))>,
    drawn: &[Circle],
    ground: &Ground,
) -> Vec<Label> {
    let mut taken: Vec<Rectangle> = Vec::new();
    let mut labels: Vec<Label> = Vec::new();
    for (text, named) in texts {
        let longest = text.lines().map(|line| line.chars().count()).max().unwrap_or(0);
        let width = ground.letter * longest as f64;
        let height = ground.line * text.lines().count() as f64;
        let cost = |(rectangle, distance): &(Rectangle, f64)| {
            let lead = rectangle.nearest(named);
            let covered =
                drawn.iter().filter(|circle| rectangle.overlaps(circle, ground.gap)).count();
            let met = taken.iter().filter(|other| rectangle.meets(other)).count();
            let crossed = taken
                .iter()
                .zip(&labels)
                .filter(|(other, label)| {
                    rectangle.is_crossed(label.lead, label.named) || other.is_crossed(lead, named)
                })
                .count();
            1e9 * met as f64 + 1e6 * crossed as f64 + 1e3 * covered as f64 + distance
        };
        let best =
            around(named, (width, height), ground).min_by(|a, b| cost(a).total_cmp(&cost(b)));
        let (rectangle, _) = best.expect("there are places around everything");
        taken.push(rectangle);
        labels.push(Label {
            text,
            named,
            place: (rectangle.left, rectangle.top + ground.line - ground.below),
            lead: rectangle.nearest(named),
        });
    }
    labels
}

/// Returns rectangles for a label around a point, within the ground, with their distances.
fn around(
    (x, y): (f64, f64),
    (width, height): (f64, f64),
    ground: &Ground,
) -> impl Iterator<Item = (Rectangle, f64)> {
    const DIRECTIONS: u32 = 16;
    let Ground { bounds, line, .. } = *ground;
    (1..=8).flat_map(move |ring| {
        let distance = 0.7 * line * f64::from(ring);
        (0..DIRECTIONS).map(move |index| {
            let (sin, cos) = libm::sincos(f64::from(index) * 2.0 * PI / f64::from(DIRECTIONS));
            let center_x = x + cos * (distance + 0.5 * width);
            let center_y = y + sin * (distance + 0.5 * height);
            // A text that is too wide is aligned at the left.
            let left = (center_x - 0.5 * width).min(bounds.right - width).max(bounds.left);
            let top = (center_y - 0.5 * height).min(bounds.bottom - height).max(bounds.top);
            let rectangle = Rectangle { left, top, right: left + width, bottom: top + height };
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
        let bounds = Rectangle { left: 0.0, top: 0.0, right: 480.0, bottom: 420.0 };
        let ground = Ground { bounds, letter: 8.0, line: 20.0, below: 5.5, gap: 5.0 };
        let labels = place(texts.collect(), &drawn, &ground);
        for (index, label) in labels.iter().enumerate() {
            let (left, base) = label.place;
            let right = left + ground.letter * 7.0;
            assert!(right < 210.0 || left > 270.0, "{label:?}");
            for other in &labels[..index] {
                let apart = (other.place.1 - base).abs() >= ground.line - 1e-9;
                assert!(
                    apart || other.place.0 > right || other.place.0 + ground.letter * 7.0 < left
                );
            }
        }
    }
}
