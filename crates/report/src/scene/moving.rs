//! The two figures in few words of SVG, for animations: hundreds of parts, and no gradient of their own.
//!
//! Every part is drawn in its own axes, along x and with its larger end of radius 1. So four gradients serve all
//! parts: two figures, lit from one side or from the other.

use core::fmt::Write as _;

use maud::{Markup, PreEscaped, html};

use super::stage::{Drawn, LIGHT, RED, Stage, WHITE};

/// Below this share of its radius a part's axis has no direction in the picture.
const SHORTEST: f64 = 0.5;

/// The gradients that [`Stage::frame`] refers to.
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
    /// Shadow and figures of one frame, without what does not move.
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

/// A part, in its own axes.
fn path(figure: &str, part: &Drawn) -> String {
    let [a, b] = part.ends;
    let (a, b) = if a.r < b.r { (b, a) } else { (a, b) };
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length = libm::hypot(dx, dy) / a.r;
    let [light_x, light_y] = LIGHT;
    let (turn_rad, length) = if length < SHORTEST {
        // Its upper side in its own axes is then the lit one.
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

/// The outline around a circle of radius 1 and a smaller one that is so far along x.
fn outline(length: f64, radius: f64) -> String {
    let cos = (1.0 - radius) / length;
    if cos >= 1.0 || length == 0.0 {
        return "M1 0A1 1 0 0 0-1 0A1 1 0 0 0 1 0Z".into();
    }
    let sin = libm::sqrt(1.0 - cos * cos);
    // Both circles are touched by two straight lines.
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
        // In its own axes a part to the right has its upper side above, one to the left below.
        assert!(part(50.0, 0.0).contains("#white-top"));
        assert!(part(-50.0, 0.0).contains("#white-bottom"));
        // What hangs down is turned by a right angle: its lower side is to the left.
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
