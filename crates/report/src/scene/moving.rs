//! Compact SVG of the two figures, for animations with hundreds of parts, without a gradient per part.
//!
//! Every part is drawn in its own axes, along x and with its larger end of radius 1. Four gradients are then
//! sufficient for all parts: two figures, each lit from either of two sides.

use core::fmt::Write as _;

use maud::{Markup, PreEscaped, html};

use super::stage::{Drawn, LIGHT, RED, Stage, WHITE};

/// Length of a part's axis, as a share of its radius, below which the axis has no direction in the picture.
const SHORTEST: f64 = 0.5;

/// Returns the gradients for [`Stage::frame`].
pub(crate) fn gradients() -> Markup {
    html! {
        defs {
            @for (figure, [lit, middle, dark]) in [("white", WHITE), ("red", RED)] {
                @for (side, shades) in [("top", [lit, middle, dark]), ("bottom", [dark, middle, lit])] {
                    linearGradient id={ (figure) "-" (side) } gradientUnits="userSpaceOnUse" x2="0" y1="-1" y2="1" {
                        @for (offset, color) in ["0", "0.5", "1"].into_iter().zip(shades) {
                            stop offset=(offset) stop-color=(color) {}
                        }
                    }
                }
            }
        }
    }
}

impl Stage<'_> {
    /// Draws shadow and figures of one frame, without the static parts.
    pub(crate) fn frame(&self) -> Markup {
        let (desired, measured) = self.figures();
        let mut parts = String::new();
        for group in self.order(&desired, &measured) {
            for (figure, drawn) in [("white", &desired), ("red", &measured)] {
                for part in &drawn[group.clone()] {
                    parts += &path(figure, part);
                }
            }
        }
        html! {
            path class="shadow" d=(self.shadow(self.desired, 1.0)) {}
            (PreEscaped(parts))
        }
    }
}

/// Draws a part in its own axes.
fn path(figure: &str, part: &Drawn) -> String {
    let [a, b] = part.ends;
    let (a, b) = if a.r < b.r { (b, a) } else { (a, b) };
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length = libm::hypot(dx, dy) / a.r;
    let [light_x, light_y] = LIGHT;
    let (turn_rad, length) = if length < SHORTEST {
        // The part is turned until its upper side, in its own axes, is the lit one.
        (libm::atan2(light_x, -light_y), 0.0)
    } else {
        (libm::atan2(dy, dx), length)
    };
    let (sin, cos) = libm::sincos(turn_rad);
    let lit = if light_x * sin - light_y * cos > 0.0 { "top" } else { "bottom" };
    let mut path = String::new();
    write!(
        path,
        r#"<path class="part" fill="url(#{figure}-{lit})" transform="translate({:.1} {:.1})rotate({:.1})scale({:.1})" d="{}"/>"#,
        a.x,
        a.y,
        turn_rad.to_degrees(),
        a.r,
        outline(length, b.r / a.r),
    )
    .expect("a string takes everything");
    path
}

/// Returns the outline around a circle of radius 1 and a smaller circle at distance `length` along x.
fn outline(length: f64, radius: f64) -> String {
    let cos = (1.0 - radius) / length;
    if cos >= 1.0 || length == 0.0 {
        return "M1 0A1 1 0 0 0-1 0A1 1 0 0 0 1 0Z".into();
    }
    let sin = libm::sqrt(1.0 - cos * cos);
    // Two straight lines are tangents of both circles.
    let (x, y) = (length + radius * cos, radius * sin);
    format!(
        "M{cos:.2}-{sin:.2}A1 1 0 1 0 {cos:.2} {sin:.2}L{x:.2} {y:.2}A{radius:.2} {radius:.2} 0 0 0 {x:.2}-{y:.2}Z"
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::labels::Circle;

    #[test]
    fn a_part_is_lit_from_above_left_however_it_lies() {
        let part = |x: f64, y: f64| {
            let ends = [Circle { x: 0.0, y: 0.0, r: 10.0 }, Circle { x, y, r: 8.0 }];
            path("white", &Drawn { ends, depth_m: 0.0 })
        };
        // In its own axes, a part to the right has its upper side up, a part to the left has it down.
        assert!(part(50.0, 0.0).contains("#white-top"));
        assert!(part(-50.0, 0.0).contains("#white-bottom"));
        // A part that points down is rotated by a right angle: its lower side is on the left.
        assert!(part(0.0, 50.0).contains("#white-bottom"));
        assert!(part(0.0, -50.0).contains("#white-top"));
        assert!(part(1.0, 0.0).contains("#white-top"));
    }

    #[test]
    fn an_outline_goes_around_both_circles() {
        assert_eq!(
            outline(5.0, 1.0),
            "M0.00-1.00A1 1 0 1 0 0.00 1.00L5.00 1.00A1.00 1.00 0 0 0 5.00-1.00Z"
        );
        assert!(!outline(0.3, 0.2).contains('L'), "the smaller circle is hidden");
    }
}
