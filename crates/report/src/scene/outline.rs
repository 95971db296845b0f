//! Outlines of parts with round ends, as paths.

use core::f64::consts::PI;
use std::fmt::Write as _;

use crate::chart::px;
use crate::labels::Circle;

/// Returns the outline around two circles, always with the same orientation.
pub(super) fn capsule(a: Circle, b: Circle) -> String {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let length = libm::sqrt(dx * dx + dy * dy);
    let mut path = String::new();
    if length <= (a.r - b.r).abs() {
        // One circle hides the other.
        let larger = if a.r > b.r { a } else { b };
        arc(&mut path, larger, 0.0, 2.0 * PI, 'M');
    } else {
        // Two straight lines are tangents of both circles.
        let along = libm::atan2(dy, dx);
        let touch = libm::acos((a.r - b.r) / length);
        arc(&mut path, b, along - touch, along + touch, 'M');
        arc(&mut path, a, along + touch, along - touch + 2.0 * PI, 'L');
    }
    path.push('Z');
    path
}

/// Appends an arc from one angle to another as cubic curves. `command` is the path command that leads to the arc's
/// start.
fn arc(path: &mut String, circle: Circle, from: f64, to: f64, command: char) {
    let pieces = libm::ceil((to - from) / (0.5 * PI) - 1e-9).max(1.0);
    let turn = (to - from) / pieces;
    // The curve touches the arc at its ends and at its middle.
    let handle = circle.r * 4.0 / 3.0 * libm::tan(0.25 * turn);
    let at = |angle: f64| {
        let (sin, cos) = libm::sincos(angle);
        (circle.x + circle.r * cos, circle.y + circle.r * sin, -sin * handle, cos * handle)
    };
    let (mut x, mut y, mut tx, mut ty) = at(from);
    let write = "a string takes everything";
    write!(path, "{command}{} {}", px(x), px(y)).expect(write);
    let mut piece = 1.0;
    while piece <= pieces {
        let (x2, y2, tx2, ty2) = at(from + turn * piece);
        write!(
            path,
            "C{} {} {} {} {} {}",
            px(x + tx),
            px(y + ty),
            px(x2 - tx2),
            px(y2 - ty2),
            px(x2),
            px(y2)
        )
        .expect(write);
        (x, y, tx, ty) = (x2, y2, tx2, ty2);
        piece += 1.0;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_capsule_goes_around_both_circles() {
        let path = capsule(Circle { x: 0.0, y: 0.0, r: 10.0 }, Circle { x: 50.0, y: 0.0, r: 10.0 });
        assert!(
            path.starts_with("M50 -10C") && path.contains("L0 10C") && path.ends_with("0 -10Z")
        );
        let hidden = capsule(Circle { x: 0.0, y: 0.0, r: 10.0 }, Circle { x: 5.0, y: 0.0, r: 2.0 });
        assert!(hidden.starts_with("M10 0C") && !hidden.contains('L'));
    }
}
