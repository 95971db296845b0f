//! A smooth curve through the rows of a motion.

use std::ops::Range;

use glam::{DQuat, DVec3, DVec4};
use sinew_rig::Mechanism;

use super::motion::{MotionError, RigMotion};
use super::rows::Rows;

/// State of a rig at an instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instant {
    /// Coordinates, ordered as [`Mechanism::home`].
    pub q: Vec<f64>,
    /// Speeds along the dofs, as in `sinew_core::coordinates`: rad/s, m/s.
    pub qd: Vec<f64>,
    /// Accelerations along the dofs: rad/s², m/s².
    pub qdd: Vec<f64>,
}

/// A motion with derivatives at any time: a [`Curve`], or a decoded show.
pub trait Performance {
    /// Returns the duration, s.
    fn duration_s(&self) -> f64;

    /// Writes the state of the rig `time_s` after the beginning. Before the beginning and after the end, the state
    /// is that of the nearer end.
    fn at(&self, time_s: f64, instant: &mut Instant);
}

/// The cubic spline through the rows of a motion: position, speed and acceleration are continuous. Its first and
/// last pieces are parabolas, so that a motion may begin and end at any speed.
///
/// Rotations are splines of the four numbers of their quaternions, then normalized.
#[derive(Debug, Clone)]
pub struct Curve {
    dt_s: f64,
    /// Coordinates of the rows. Signs of quaternions are consistent from row to row.
    rows: Rows,
    /// Second derivatives of the coordinates at the rows, 1/s², in the layout of the rows.
    bends: Vec<f64>,
    pieces: Vec<Piece>,
}

/// Coordinates of a row that are computed in the same way.
#[derive(Debug, Clone)]
enum Piece {
    /// Coordinates of consecutive joints with single axes.
    Scalars(Range<usize>),
    /// A rotation, from this index.
    Rotation(usize),
    /// A rotation, then a translation, from this index.
    Free(usize),
}

impl Curve {
    /// Creates the curve of a motion. O(rows).
    ///
    /// # Errors
    /// [`MotionError`] if the motion is invalid for the rig.
    pub fn new(mechanism: &Mechanism, motion: &RigMotion) -> Result<Self, MotionError> {
        motion.check(mechanism)?;
        let joints = mechanism.coordinate_ranges();
        let rows = Rows::of(mechanism.coordinate_count(), &motion.rows);
        Ok(Self::through(&joints, rows, motion.dt_s))
    }

    /// Creates the curve through at least two rows, which are a valid motion of the rig.
    pub(super) fn through(joints: &[Range<usize>], mut rows: Rows, dt_s: f64) -> Self {
        align_quaternions(joints, &mut rows);
        let mut pieces: Vec<Piece> = Vec::new();
        for range in joints.iter().filter(|range| !range.is_empty()) {
            match (range.len(), pieces.last_mut()) {
                (7, _) => pieces.push(Piece::Free(range.start)),
                (4, _) => pieces.push(Piece::Rotation(range.start)),
                (_, Some(Piece::Scalars(last))) if last.end == range.start => last.end = range.end,
                _ => pieces.push(Piece::Scalars(range.clone())),
            }
        }
        let bends = bends(&rows, dt_s);
        Self { dt_s, rows, bends, pieces }
    }

    /// Samples the curve at `rate_hz`, with at least two samples. Samples at the time of a row equal the row.
    pub fn resampled(&self, rate_hz: f64) -> RigMotion {
        let dt_s = rate_hz.recip();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let count = (self.duration_s() * rate_hz + 1e-6).floor() as usize + 1;
        let times_s = (0..count.max(2)).map(|row| row as f64 * dt_s);
        RigMotion { dt_s, rows: self.rows_at(times_s).lists() }
    }

    /// Returns the coordinates at these times.
    pub(super) fn rows_at(&self, times_s: impl Iterator<Item = f64>) -> Rows {
        let mut instant = Instant::default();
        let width = self.rows.width;
        let mut rows = Rows { width, count: 0, numbers: Vec::new() };
        rows.numbers.reserve_exact(times_s.size_hint().0 * width);
        for time_s in times_s {
            self.at(time_s, &mut instant);
            rows.numbers.extend_from_slice(&instant.q);
            rows.count += 1;
        }
        rows
    }

    /// Returns the rows that the curve was created from.
    pub(super) fn into_rows(self) -> Rows {
        self.rows
    }

    /// Returns the time from row to row, s.
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }
}

impl Performance for Curve {
    fn duration_s(&self) -> f64 {
        (self.rows.count - 1) as f64 * self.dt_s
    }

    fn at(&self, time_s: f64, instant: &mut Instant) {
        let last = self.rows.count - 2;
        let place = (time_s / self.dt_s).clamp(0.0, (last + 1) as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the rows"
        )]
        let row = (place.floor() as usize).min(last);
        let (b, h, width) = (place - row as f64, self.dt_s, self.rows.width);
        let a = 1.0 - b;
        let [from, to] = [self.rows.row(row), self.rows.row(row + 1)];
        let [bend, bend_to] = [row, row + 1].map(|row| &self.bends[row * width..][..width]);
        let [of_value, of_value_to] = [a, b].map(|x| (x * x * x - x) * h * h / 6.0);
        let [of_slope, of_slope_to] = [a, b].map(|x| (3.0 * x * x - 1.0) * h / 6.0);
        let value =
            |k: usize| a * from[k] + b * to[k] + of_value * bend[k] + of_value_to * bend_to[k];
        let slope =
            |k: usize| (to[k] - from[k]) / h + of_slope_to * bend_to[k] - of_slope * bend[k];
        let bent = |k: usize| a * bend[k] + b * bend_to[k];
        let Instant { q, qd, qdd } = instant;
        q.clear();
        qd.clear();
        qdd.clear();
        for piece in &self.pieces {
            let (first, is_free) = match piece {
                Piece::Scalars(range) => {
                    q.extend(range.clone().map(value));
                    qd.extend(range.clone().map(slope));
                    qdd.extend(range.clone().map(bent));
                    continue;
                }
                Piece::Rotation(first) => (*first, false),
                Piece::Free(first) => (*first, true),
            };
            let four = |of: &dyn Fn(usize) -> f64| {
                DVec4::from_array(std::array::from_fn(|k| of(first + k)))
            };
            let turn = Turning::of(four(&value), four(&slope), four(&bent));
            q.extend(turn.rotation.to_array());
            qd.extend(turn.speed.to_array());
            qdd.extend(turn.acceleration.to_array());
            if is_free {
                // Speed and acceleration of a free joint are along the body's axes.
                let three = |of: &dyn Fn(usize) -> f64| {
                    DVec3::from_array(std::array::from_fn(|k| of(first + 4 + k)))
                };
                let to_body = turn.rotation.conjugate();
                q.extend(three(&value).to_array());
                qd.extend((to_body * three(&slope)).to_array());
                qdd.extend((to_body * three(&bent)).to_array());
            }
        }
    }
}

/// State of a rotating body; speed and acceleration in its axes.
struct Turning {
    rotation: DQuat,
    speed: DVec3,
    acceleration: DVec3,
}

impl Turning {
    /// Computes the state from a moving quaternion `p` that is not of unit length: with q = p / |p| the speed is 2
    /// vec(p* p') / |p|².
    fn of(p: DVec4, slope: DVec4, bend: DVec4) -> Self {
        let quaternion = |v: DVec4| DQuat::from_xyzw(v.x, v.y, v.z, v.w);
        let squared = p.dot(p);
        let back = quaternion(p).conjugate();
        let along = |v: DVec4| (back * quaternion(v)).xyz() * (2.0 / squared);
        let speed = along(slope);
        Self {
            rotation: quaternion(p / libm::sqrt(squared)),
            speed,
            // The product of p' with itself has no vector part; the length changes by 2 p · p'.
            acceleration: along(bend) - speed * (2.0 * p.dot(slope) / squared),
        }
    }
}

/// Makes the signs of quaternions consistent from row to row, so that their numbers do not jump.
pub(super) fn align_quaternions(joints: &[Range<usize>], rows: &mut Rows) {
    for range in joints.iter().filter(|range| range.len() >= 4) {
        let turn = range.start..range.start + 4;
        for row in 1..rows.count {
            let (before, rest) = rows.numbers.split_at_mut(row * rows.width);
            let before = &before[(row - 1) * rows.width..][turn.clone()];
            let now = &mut rest[turn.clone()];
            let dot: f64 = before.iter().zip(now.iter()).map(|(a, b)| a * b).sum();
            if dot < 0.0 {
                for x in now {
                    *x = -*x;
                }
            }
        }
    }
}

/// Returns the second derivatives of the spline at the rows, from a tridiagonal system for each coordinate (Thomas
/// algorithm).
fn bends(rows: &Rows, dt_s: f64) -> Vec<f64> {
    let (count, width) = (rows.count, rows.width);
    let mut bends = vec![0.0; count * width];
    if count < 3 {
        return bends;
    }
    // m[i-1] + 4 m[i] + m[i+1] = 6 (y[i-1] - 2 y[i] + y[i+1]) / h². At an end, m equals that of the next row.
    let mut shares = vec![0.0; count];
    let scale = 6.0 / (dt_s * dt_s);
    for row in 1..count - 1 {
        let ends = f64::from(u8::from(row == 1) + u8::from(row == count - 2));
        let share = 1.0 / (4.0 + ends - shares[row - 1]);
        shares[row] = share;
        let (before, now) = bends.split_at_mut(row * width);
        let last = &before[(row - 1) * width..];
        let [y0, y1, y2] = [row - 1, row, row + 1].map(|row| rows.row(row));
        for ((bend, last), ((y0, y1), y2)) in
            now.iter_mut().zip(last).zip(y0.iter().zip(y1).zip(y2))
        {
            *bend = (scale * (y0 - 2.0 * y1 + y2) - last) * share;
        }
    }
    for row in (1..count - 2).rev() {
        let (before, behind) = bends.split_at_mut((row + 1) * width);
        for (bend, next) in before[row * width..].iter_mut().zip(&behind[..width]) {
            *bend -= shares[row] * next;
        }
    }
    bends.copy_within(width..2 * width, 0);
    bends.copy_within((count - 2) * width..(count - 1) * width, (count - 1) * width);
    bends
}
