//! The ends of ranges, for an interior-point method: a gap that is positive inside, and a force that keeps it
//! positive.

use glam::DQuat;
use sinew_core::projection::JointRange;

use super::joint::{JointPosition, rotation_vector};

/// An end of a range, near a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// Column of the Jacobian along which the gap changes.
    pub(super) column: usize,
    /// Number of columns, starting at `column`, along which the gap is curved.
    pub(super) bends: usize,
    /// Distance from the end, positive inside.
    pub(super) gap: f64,
    /// Derivative of the gap along the column.
    pub(super) slope: f64,
    /// Second derivative of the gap along each column along which it is curved.
    pub(super) bend: f64,
    /// Force that pushes inwards along the gap: the Lagrange multiplier.
    pub(super) force: f64,
}

/// Maximum share of a gap or a force that a step may use up.
const MOST: f64 = 0.99;

/// Widening of the range of an axis, rad or m, to give a locked axis an interior.
const WIDER: f64 = 1e-9;

impl Limit {
    /// Returns the largest share of a step along the limit's column, at most 1, after which a part of the gap is left.
    /// Assumes that the gap is not curved.
    pub(super) fn share(&self, step: f64) -> f64 {
        let way = -self.slope * step;
        if way > MOST * self.gap { MOST * self.gap / way } else { 1.0 }
    }

    /// Returns whether a step left enough of the gap. A step may use up the share [`MOST`] of the gap; the gap's
    /// curvature may then reduce the rest by half.
    pub(super) fn is_left(&self, before: &Self) -> bool {
        self.gap >= 0.5 * (1.0 - MOST) * before.gap
    }

    /// Returns the force after a step along the limit's column. Its product with the gap is then `height`, to first
    /// order; but the force keeps at least the share `1 - MOST` of its value.
    pub(super) fn force_after(&self, step: f64, height: f64) -> f64 {
        let after = (height - self.force * self.slope * step) / self.gap;
        after.max((1.0 - MOST) * self.force)
    }
}

/// Returns the range, or no range if it limits nothing: a range of half a turn permits any rotation.
pub(super) fn real(range: JointRange) -> JointRange {
    match range {
        JointRange::Turn(most) if most >= std::f32::consts::PI => JointRange::Any,
        other => other,
    }
}

/// Appends the limits of a joint whose first column is `column`.
pub(super) fn of_joint(
    state: &JointPosition,
    range: JointRange,
    column: usize,
    out: &mut Vec<Limit>,
) {
    let mut axis = |column: usize, x: f64, [least, most]: [f32; 2]| {
        for (gap, slope) in [(x - f64::from(least), 1.0), (f64::from(most) - x, -1.0)] {
            out.push(Limit { column, bends: 0, gap: gap + WIDER, slope, bend: 0.0, force: 0.0 });
        }
    };
    match (range, *state) {
        (JointRange::Axis(ends), JointPosition::Along([a, _])) => axis(column, a, ends),
        (JointRange::Axes([first, second]), JointPosition::Along([a, b])) => {
            axis(column, a, first);
            axis(column + 1, b, second);
        }
        // The cosine of half the angle is smooth everywhere, and its curvature is equal in all directions.
        (JointRange::Turn(most), JointPosition::Turn(q)) => {
            let (half, end) = (0.5 * rotation_vector(q).length(), 0.5 * f64::from(most));
            // cos half - cos end, without cancellation of their common digits.
            let gap = 2.0 * libm::sin(0.5 * (end + half)) * libm::sin(0.5 * (end - half));
            let (slope, bend) = (-0.5 * libm::sin(half), -0.25 * libm::cos(half));
            out.push(Limit { column, bends: 3, gap, slope, bend, force: 0.0 });
        }
        _ => {}
    }
}

/// Returns the state moved at least a share `margin` of the range's width away from its ends.
pub(super) fn within(state: &JointPosition, range: JointRange, margin: f64) -> JointPosition {
    let inside = |x: f64, [least, most]: [f32; 2]| {
        let (least, most) = (f64::from(least), f64::from(most));
        let margin = margin * (most - least);
        x.max(least + margin).min(most - margin)
    };
    match (range, *state) {
        (JointRange::Axis(ends), JointPosition::Along([a, b])) => {
            JointPosition::Along([inside(a, ends), b])
        }
        (JointRange::Axes([first, second]), JointPosition::Along([a, b])) => {
            JointPosition::Along([inside(a, first), inside(b, second)])
        }
        (JointRange::Turn(most), JointPosition::Turn(q)) => {
            let (vector, most) = (rotation_vector(q), f64::from(most) * (1.0 - margin));
            let is_outside = vector.length() > most;
            let turn =
                if is_outside { DQuat::from_scaled_axis(vector.normalize() * most) } else { q };
            JointPosition::Turn(turn)
        }
        _ => *state,
    }
}
