//! A drive of one servo and one joint, by a monotone curve through points.

use heapless::Vec;

use super::error::DriveError;
use super::numbers::{LARGEST, LEAST_MOTION, Numbers, bounded, collect};
use super::pose::{DrivePose, Tangent};
use crate::limited::LimitReason;

/// Maximum number of points of a curve.
pub const CURVE_CAPACITY: usize = 16;

/// Minimum distance of two points, rad of the servo: less than one step of an encoder with 4096 steps.
const LEAST_GAP: f32 = 1e-3;

/// Minimum accepted slope, as a share of the mean slope.
const LEAST_SHARE: f32 = 0.01;

/// Maximum steps of the inverse. Newton's method needs about five, and ten for the flattest accepted curves; a test
/// checks this.
const STEPS: usize = 12;

/// A monotone curve `q(s)` through points, whose derivative is continuous and nowhere near zero. It is used for jaws,
/// lids and push-rods.
///
/// The curve consists of cubics between the points, with the slopes of Fritsch and Butland (1984), which keep it
/// monotone. At an end, the slope is that of a parabola through three points, limited to 1/4 to 3 times the slope
/// between the last two.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    knots: Vec<Knot, CURVE_CAPACITY>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Knot {
    servo: f32,
    joint: f32,
    slope: f32,
}

impl Curve {
    /// Creates a curve through points `[s, q]`: `s` in rad and rising, `q` in rad or m and all rising or all
    /// falling.
    ///
    /// # Errors
    /// [`DriveError`] if there are fewer than 2 or more than [`CURVE_CAPACITY`] points, a number is not finite or above
    /// 1e6 in absolute value, servo positions do not rise by at least 0.001 rad, joint positions change direction, the
    /// mean slope is below 1e-6, or the slope is anywhere below 1/100 of the mean slope.
    pub fn new(points: &[[f32; 2]]) -> Result<Self, DriveError> {
        let (what, found) = ("points", points.len());
        let [first, .., last] = points else {
            return Err(DriveError::TooFew { what, found, least: 2 });
        };
        if found > CURVE_CAPACITY {
            return Err(DriveError::TooMany { what, found, most: CURVE_CAPACITY });
        }
        for (index, [servo, joint]) in points.iter().enumerate() {
            bounded("servo position of point", index, *servo, [-LARGEST, LARGEST])?;
            bounded("joint position of point", index, *joint, [-LARGEST, LARGEST])?;
        }
        let mut secants = Vec::<Secant, CURVE_CAPACITY>::new();
        for (before, pair) in points.windows(2).enumerate() {
            let [[s0, q0], [s1, q1]] = pair else { continue };
            let point = before.saturating_add(1);
            if s1 - s0 < LEAST_GAP {
                return Err(DriveError::NotRising { point });
            }
            if (q1 - q0) * (last[1] - first[1]) <= 0.0 {
                return Err(DriveError::NotMonotone { point });
            }
            // There is room, because the points were counted.
            let _ = secants.push(Secant { width: s1 - s0, slope: (q1 - q0) / (s1 - s0) });
        }
        let mean = (last[1] - first[1]) / (last[0] - first[0]);
        if mean.abs() < LEAST_MOTION {
            return Err(DriveError::Unmoved { dof: 0, largest: mean.abs() });
        }
        let mut knots = Vec::new();
        for (index, [servo, joint]) in points.iter().enumerate() {
            let slope = slope_at(&secants, index);
            let _ = knots.push(Knot { servo: *servo, joint: *joint, slope });
        }
        let curve = Self { knots };
        let share = curve
            .pieces()
            .map(|piece| piece.least_slope(mean.signum()))
            .fold(f32::INFINITY, f32::min)
            / mean.abs();
        // NaN is not in the range either.
        if !(LEAST_SHARE..).contains(&share) {
            return Err(DriveError::Flat { share, least: LEAST_SHARE });
        }
        Ok(curve)
    }

    /// Returns the points `[s, q]` of the curve.
    pub fn points(&self) -> impl ExactSizeIterator<Item = [f32; 2]> {
        self.knots.iter().map(|knot| [knot.servo, knot.joint])
    }

    fn pieces(&self) -> impl Iterator<Item = Piece> {
        self.knots.windows(2).filter_map(|pair| match pair {
            [from, to] => Some(Piece { from: *from, to: *to }),
            _ => None,
        })
    }

    pub(super) fn at_servo(&self, s: f32) -> DrivePose<'_> {
        self.pose(
            s,
            |piece| s <= piece.to.servo,
            |knot| s < knot.servo,
            |piece| (s - piece.from.servo) / piece.width(),
        )
    }

    pub(super) fn at_joint(&self, q: f32) -> DrivePose<'_> {
        // Comparisons are reversed for a falling curve.
        let rising = self.pieces().next().is_none_or(|piece| piece.to.joint > piece.from.joint);
        let is_below = |a: f32, b: f32| if rising { a < b } else { a > b };
        self.pose(
            q,
            |piece| !is_below(piece.to.joint, q),
            |knot| is_below(q, knot.joint),
            |piece| piece.inverse(q),
        )
    }

    /// Finds the pose of a wanted position in the first piece for which `reached` is true; `share_of` returns the share
    /// of the piece's width. Beyond the curve, returns its nearest end: the first end if `before` is true for it,
    /// otherwise the last.
    fn pose(
        &self,
        wanted: f32,
        reached: impl Fn(&Piece) -> bool,
        before: impl Fn(&Knot) -> bool,
        share_of: impl Fn(&Piece) -> f32,
    ) -> DrivePose<'_> {
        let at = |knot: &Knot, reason| pose_of(knot.servo, knot.joint, knot.slope, reason);
        match (self.knots.first(), self.pieces().find(reached), self.knots.last()) {
            (Some(first), ..) if before(first) => at(first, Some(LimitReason::Range)),
            (_, Some(piece), _) => {
                let share = share_of(&piece);
                let servo = piece.from.servo + share * piece.width();
                pose_of(servo, piece.joint(share), piece.slope(share), None)
            }
            (_, None, Some(last)) => at(last, Some(LimitReason::Range)),
            // A curve has at least two points, therefore this is not reached.
            (_, None, None) => pose_of(wanted, wanted, 1.0, Some(LimitReason::Range)),
        }
    }
}

fn pose_of(servo: f32, joint: f32, slope: f32, reason: Option<LimitReason>) -> DrivePose<'static> {
    let one = |number: f32| -> Numbers { collect([number]) };
    DrivePose { joints: one(joint), servos: one(servo), reason, tangent: Tangent::Slope(slope) }
}

#[derive(Debug, Clone, Copy)]
struct Secant {
    width: f32,
    slope: f32,
}

/// Returns the slope of the curve at a point.
fn slope_at(secants: &[Secant], point: usize) -> f32 {
    let at = |index: usize| secants.get(index).copied();
    let before = point.checked_sub(1).and_then(at);
    match (before, at(point)) {
        // The harmonic mean, weighted by the widths.
        (Some(a), Some(b)) => {
            let (wa, wb) = (2.0 * b.width + a.width, b.width + 2.0 * a.width);
            (wa + wb) / (wa / a.slope + wb / b.slope)
        }
        (None, Some(end)) => end_slope(end, at(1)),
        (Some(end), None) => end_slope(end, point.checked_sub(2).and_then(at)),
        (None, None) => 0.0,
    }
}

/// Returns the slope at an end, from the secant there and the next one.
fn end_slope(end: Secant, behind: Option<Secant>) -> f32 {
    let Some(behind) = behind else { return end.slope };
    let weight = end.width / (end.width + behind.width);
    // A share of the end's own slope keeps its direction.
    let share = 1.0 + weight * (1.0 - behind.slope / end.slope);
    end.slope * share.clamp(0.25, 3.0)
}

/// The cubic between two knots.
struct Piece {
    from: Knot,
    to: Knot,
}

impl Piece {
    fn width(&self) -> f32 {
        self.to.servo - self.from.servo
    }

    /// Returns the coefficients `a, b, c` of `y = t (a + t (b + t c))`: `y` is the share of the piece's height at
    /// the share `t` of its width.
    fn cubic(&self) -> [f32; 3] {
        let secant = (self.to.joint - self.from.joint) / self.width();
        let (from, to) = (self.from.slope / secant, self.to.slope / secant);
        [from, 3.0 - 2.0 * from - to, from + to - 2.0]
    }

    fn joint(&self, share: f32) -> f32 {
        let [a, b, c] = self.cubic();
        let height = self.to.joint - self.from.joint;
        self.from.joint + height * (share * (a + share * (b + share * c)))
    }

    fn slope(&self, share: f32) -> f32 {
        let [a, b, c] = self.cubic();
        let height = self.to.joint - self.from.joint;
        (a + share * (2.0 * b + share * (3.0 * c))) * (height / self.width())
    }

    /// Returns the minimum slope, in the direction of `sign`.
    fn least_slope(&self, sign: f32) -> f32 {
        let [_, b, c] = self.cubic();
        let lowest = -b / (3.0 * c);
        // NaN, from a straight line, fails both comparisons.
        let lowest = if lowest > 0.0 && lowest < 1.0 { lowest } else { 0.0 };
        [0.0, lowest, 1.0]
            .into_iter()
            .map(|share| self.slope(share) * sign)
            .fold(f32::INFINITY, f32::min)
    }

    /// Returns the share of the piece's width, 0 to 1, at which the joint's position is `q`. Uses Newton's method,
    /// safeguarded by bisection.
    fn inverse(&self, q: f32) -> f32 {
        let [a, b, c] = self.cubic();
        let wanted = (q - self.from.joint) / (self.to.joint - self.from.joint);
        let (mut low, mut high) = (0.0, 1.0);
        let mut share = wanted.clamp(0.0, 1.0);
        for _ in 0..STEPS {
            let error = share * (a + share * (b + share * c)) - wanted;
            if error > 0.0 {
                high = share;
            } else {
                low = share;
            }
            let next = share - error / (a + share * (2.0 * b + share * (3.0 * c)));
            share = if next >= low && next <= high { next } else { 0.5 * (low + high) };
        }
        share
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates a piece of unit width and height, with slopes in units of its secant.
    fn piece(from: f32, to: f32) -> Piece {
        Piece {
            from: Knot { servo: 0.0, joint: 0.0, slope: from },
            to: Knot { servo: 1.0, joint: 1.0, slope: to },
        }
    }

    #[test]
    fn the_steps_of_the_inverse_are_enough_for_the_flattest_piece() {
        let (mut worst, mut tried) = (0.0_f32, 0);
        for (from, to) in (0..=60).flat_map(|a| (0..=60).map(move |b| (a, b))) {
            #[expect(clippy::cast_precision_loss, reason = "small")]
            let piece = piece(0.05 * from as f32, 0.05 * to as f32);
            // A piece may be 15 times as steep as the mean, and is then flat in its own units.
            if piece.least_slope(1.0) < LEAST_SHARE / 15.0 {
                continue;
            }
            tried += 1;
            for step in 0..=100_u8 {
                let joint = f32::from(step) / 100.0;
                let share = piece.inverse(joint);
                worst = worst.max((piece.joint(share) - joint).abs());
            }
        }
        assert!(tried > 3000, "{tried}");
        // Tolerance for a few roundings of a sum of three terms of at most 3.
        assert!(worst < 1e-6, "{worst}");
    }
}
