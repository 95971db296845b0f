//! The ends of ranges, as interior-point methods take them: a gap that is positive inside, and a force that keeps it
//! so.

use glam::DQuat;
use sinew_core::projection::JointRange;

use super::joint::{JointPosition, rotation_vector};

/// An end of a range, near a pose.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limit {
    /// The column of the Jacobian along which it is.
    pub(super) column: usize,
    /// How many columns the gap bends along, from that one on.
    pub(super) bends: usize,
    /// How far the end is, positive inside.
    pub(super) gap: f64,
    /// Derivative of the gap along the column.
    pub(super) slope: f64,
    /// Second derivative of the gap along each column that it bends along.
    pub(super) bend: f64,
    /// How strongly it pushes inwards along the gap: Lagrange's multiplier.
    pub(super) force: f64,
}

/// Of a gap or a force, the most that a step takes.
const MOST: f64 = 0.99;

/// So much wider is the range of an axis, rad or m, for an axis that is locked to have an inside.
const WIDER: f64 = 1e-9;

impl Limit {
    /// The share of a step along its column that leaves some of the gap, if the gap did not bend.
    pub(super) fn share(&self, step: f64) -> f64 {
        let way = -self.slope * step;
        if way > MOST * self.gap { MOST * self.gap / way } else { 1.0 }
    }

    /// Whether it is still as far as steps leave it, `before` a step that its bend is allowed to shorten by half.
    pub(super) fn is_left(&self, before: &Self) -> bool {
        self.gap >= 0.5 * (1.0 - MOST) * before.gap
    }

    /// The force after a step along its column, so that its product with the gap is `height`, to first order.
    pub(super) fn force_after(&self, step: f64, height: f64) -> f64 {
        let after = (height - self.force * self.slope * step) / self.gap;
        after.max((1.0 - MOST) * self.force)
    }
}

/// A range that limits something: up to half a turn is any turn.
pub(super) fn real(range: JointRange) -> JointRange {
    match range {
        JointRange::Turn(most) if most >= std::f32::consts::PI => JointRange::Any,
        other => other,
    }
}

/// The limits of a joint whose first column is `column`.
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
        // The cosine of half the angle is smooth everywhere, and bends alike in all directions.
        (JointRange::Turn(most), JointPosition::Turn(q)) => {
            let (half, end) = (0.5 * rotation_vector(q).length(), 0.5 * f64::from(most));
            // cos half - cos end, without the digits that they have in common.
            let gap = 2.0 * libm::sin(0.5 * (end + half)) * libm::sin(0.5 * (end - half));
            let (slope, bend) = (-0.5 * libm::sin(half), -0.25 * libm::cos(half));
            out.push(Limit { column, bends: 3, gap, slope, bend, force: 0.0 });
        }
        _ => {}
    }
}

/// The state, at least a share `margin` of the range's width away from its ends.
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
