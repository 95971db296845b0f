//! A smooth curve through the samples of a motion.

use std::ops::Range;

use glam::{DQuat, DVec3, DVec4};
use sinew_rig::Mechanism;

use super::motion::{MotionError, RigMotion};

/// What a rig does at an instant.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Instant {
    /// Coordinates as [`Mechanism::home`].
    pub q: Vec<f64>,
    /// Speeds along the degrees of freedom, as `sinew_core::coordinates` has them: rad/s, m/s.
    pub qd: Vec<f64>,
    /// Accelerations along them: rad/s², m/s².
    pub qdd: Vec<f64>,
}

/// A motion with derivatives at any time: a [`Curve`], or a decoded show.
pub trait Performance {
    /// How long it takes, s.
    fn duration_s(&self) -> f64;

    /// What the rig does `time_s` after the beginning; before it and after the end, what it does there.
    fn at(&self, time_s: f64, instant: &mut Instant);
}

/// The cubic spline through the rows of a motion: position, speed and acceleration are continuous. Its first and its
/// last piece are parabolas, so that a motion may begin and end in full swing.
///
/// Rotations are splines of the four numbers of their quaternions, made unit.
#[derive(Debug, Clone)]
pub struct Curve {
    dt_s: f64,
    /// Coordinates of the rows, with the quaternions of one sign.
    rows: Vec<Vec<f64>>,
    /// Second derivatives of the coordinates at the rows, per second squared.
    bends: Vec<Vec<f64>>,
    /// Where in a row the coordinates of each joint are.
    joints: Vec<Range<usize>>,
}

impl Curve {
    /// The curve of a motion. O(rows).
    ///
    /// # Errors
    /// [`MotionError`] if it is no motion of the rig.
    pub fn new(mechanism: &Mechanism, motion: &RigMotion) -> Result<Self, MotionError> {
        motion.check(mechanism)?;
        let joints = mechanism.coordinate_ranges();
        let mut rows = motion.rows.clone();
        align_quaternions(&joints, &mut rows);
        let bends = bends(&rows, motion.dt_s);
        Ok(Self { dt_s: motion.dt_s, rows, bends, joints })
    }

    /// Samples of the curve, `rate_hz` of them a second, at least two. Where they fall on rows, they are the rows.
    pub fn resampled(&self, rate_hz: f64) -> RigMotion {
        let dt_s = rate_hz.recip();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let count = (self.duration_s() * rate_hz + 1e-6).floor() as usize + 1;
        let mut instant = Instant::default();
        let rows = (0..count.max(2)).map(|row| {
            self.at(row as f64 * dt_s, &mut instant);
            instant.q.clone()
        });
        RigMotion { dt_s, rows: rows.collect() }
    }

    /// Time from row to row, s.
    pub fn dt_s(&self) -> f64 {
        self.dt_s
    }
}

impl Performance for Curve {
    fn duration_s(&self) -> f64 {
        (self.rows.len() - 1) as f64 * self.dt_s
    }

    fn at(&self, time_s: f64, instant: &mut Instant) {
        let last = self.rows.len() - 2;
        let place = (time_s / self.dt_s).clamp(0.0, (last + 1) as f64);
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "clamped to the rows"
        )]
        let row = (place.floor() as usize).min(last);
        let (b, h) = (place - row as f64, self.dt_s);
        let a = 1.0 - b;
        let [from, to] = [&self.rows[row], &self.rows[row + 1]];
        let [bend, bend_to] = [&self.bends[row], &self.bends[row + 1]];
        let value = |k: usize| {
            let cubic = (a * a * a - a) * bend[k] + (b * b * b - b) * bend_to[k];
            a * from[k] + b * to[k] + cubic * h * h / 6.0
        };
        let slope = |k: usize| {
            let cubic = (3.0 * b * b - 1.0) * bend_to[k] - (3.0 * a * a - 1.0) * bend[k];
            (to[k] - from[k]) / h + cubic * h / 6.0
        };
        let bent = |k: usize| a * bend[k] + b * bend_to[k];
        let Instant { q, qd, qdd } = instant;
        q.clear();
        qd.clear();
        qdd.clear();
        for range in &self.joints {
            let mut scalars = range.clone();
            if range.len() >= 4 {
                let four = |of: &dyn Fn(usize) -> f64| {
                    DVec4::from_array(std::array::from_fn(|k| of(range.start + k)))
                };
                let [p, v, w] = [four(&value), four(&slope), four(&bent)];
                let turn = Turning::of(p, v, w);
                q.extend(turn.rotation.to_array());
                qd.extend(turn.speed.to_array());
                qdd.extend(turn.acceleration.to_array());
                scalars.start += 4;
                // A free joint's way is told along the body's axes.
                let three = |of: &dyn Fn(usize) -> f64| {
                    DVec3::from_array(std::array::from_fn(|k| of(scalars.start + k)))
                };
                if scalars.len() == 3 {
                    let to_body = turn.rotation.conjugate();
                    q.extend(three(&value).to_array());
                    qd.extend((to_body * three(&slope)).to_array());
                    qdd.extend((to_body * three(&bent)).to_array());
                }
                continue;
            }
            q.extend(scalars.clone().map(value));
            qd.extend(scalars.clone().map(slope));
            qdd.extend(scalars.map(bent));
        }
    }
}

/// A turning body, speeds and accelerations in its axes.
struct Turning {
    rotation: DQuat,
    speed: DVec3,
    acceleration: DVec3,
}

impl Turning {
    /// Of four numbers `p` on their way, not of unit length: with q = p / |p| the speed is 2 vec(p* p') / |p|².
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

/// Gives quaternions one sign from row to row, so that their numbers have no jumps.
pub(super) fn align_quaternions(joints: &[Range<usize>], rows: &mut [Vec<f64>]) {
    for range in joints.iter().filter(|range| range.len() >= 4) {
        let turn = range.start..range.start + 4;
        for row in 1..rows.len() {
            let (before, rest) = rows.split_at_mut(row);
            let (before, now) = (&before[row - 1][turn.clone()], &mut rest[0][turn.clone()]);
            let dot: f64 = before.iter().zip(now.iter()).map(|(a, b)| a * b).sum();
            if dot < 0.0 {
                for x in now {
                    *x = -*x;
                }
            }
        }
    }
}

/// Second derivatives of the spline at the rows: a tridiagonal system for each coordinate, by Thomas.
fn bends(rows: &[Vec<f64>], dt_s: f64) -> Vec<Vec<f64>> {
    let (count, width) = (rows.len(), rows[0].len());
    let mut bends = vec![vec![0.0; width]; count];
    if count < 3 {
        return bends;
    }
    // m[i-1] + 4 m[i] + m[i+1] = 6 (y[i-1] - 2 y[i] + y[i+1]) / h². The ends bend as their neighbours do.
    let mut shares = vec![0.0; count];
    for row in 1..count - 1 {
        let ends = f64::from(u8::from(row == 1) + u8::from(row == count - 2));
        shares[row] = 1.0 / (4.0 + ends - shares[row - 1]);
        for k in 0..width {
            let second = rows[row - 1][k] - 2.0 * rows[row][k] + rows[row + 1][k];
            bends[row][k] = (6.0 * second / (dt_s * dt_s) - bends[row - 1][k]) * shares[row];
        }
    }
    for row in (1..count - 2).rev() {
        let (before, behind) = bends.split_at_mut(row + 1);
        for (bend, next) in before[row].iter_mut().zip(&behind[0]) {
            *bend -= shares[row] * next;
        }
    }
    let ends = [bends[1].clone(), bends[count - 2].clone()];
    for (row, end) in [0, count - 1].into_iter().zip(ends) {
        bends[row] = end;
    }
    bends
}
