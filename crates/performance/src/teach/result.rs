//! Converts the measured positions of a led rig to a motion: removes rest at both ends, and noise.

use sinew_mocap::filter::LowPass;
use sinew_retarget::feasibility::{Curve, Instant, MotionError, Performance as _, RigMotion};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

use super::GuideTrajectory;

/// A joint within this distance of its first or last position is at rest: half a degree; for a slide half a
/// millimetre.
pub const REST_RAD: f64 = 0.008_726_6;
const REST_M: f64 = 0.5e-3;
/// Rest that is kept at both ends, s.
const LEFT_S: f64 = 0.25;

/// Error of a recording without a motion.
#[derive(Debug, Error)]
pub enum TeachResultError {
    /// No joint was moved.
    #[error("no joint moved by more than 0.5 deg: nothing was taught")]
    Rest,
    /// The cutoff frequency is too high.
    #[error(
        "--cutoff-hz: expected a frequency below half of the {rate_hz} rows a second, found {cutoff_hz} Hz"
    )]
    Cutoff {
        /// Rows per second.
        rate_hz: f64,
        /// The requested cutoff, Hz.
        cutoff_hz: f64,
    },
    /// The rows are not a motion of the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// A motion that was taught by hand.
#[derive(Debug, Clone)]
pub struct TeachResult {
    /// The taught motion, without rest and noise.
    pub motion: RigMotion,
    /// Durations of the rest that was removed before and after the motion, s.
    pub cut_s: [f64; 2],
    /// Largest change of a coordinate by the low-pass filter, rad or m.
    pub smoothed: f64,
}

impl TeachResult {
    /// Makes a motion from measured rows. `cutoff_hz`: cutoff of the low-pass filter, 0 for no filter; `rate_hz`:
    /// rows per second of the motion.
    ///
    /// # Errors
    /// [`TeachResultError`] if no joint moved, or the cutoff or the rows are invalid.
    pub fn new(
        mechanism: &Mechanism,
        measured: &RigMotion,
        cutoff_hz: f64,
        rate_hz: f64,
    ) -> Result<Self, TeachResultError> {
        measured.check(mechanism)?;
        let dt_s = measured.dt_s;
        let mut rows = measured.rows.clone();
        let smoothed = smooth(mechanism, &mut rows, dt_s, cutoff_hz)?;
        let (first, last) = moving(mechanism, &rows).ok_or(TeachResultError::Rest)?;
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "small")]
        let left = (LEFT_S / dt_s).round() as usize;
        let (begin, end) = (first.saturating_sub(left), (last + left).min(rows.len() - 1));
        let cut_s = [begin as f64 * dt_s, (rows.len() - 1 - end) as f64 * dt_s];
        rows.truncate(end + 1);
        rows.drain(..begin);
        let motion = Curve::new(mechanism, &RigMotion { dt_s, rows })?.resampled(rate_hz);
        Ok(Self { motion, cut_s, smoothed })
    }
}

/// Filters all coordinates. Returns the largest change of a coordinate.
fn smooth(
    mechanism: &Mechanism,
    rows: &mut [Vec<f64>],
    dt_s: f64,
    cutoff_hz: f64,
) -> Result<f64, TeachResultError> {
    if cutoff_hz <= 0.0 {
        return Ok(0.0);
    }
    let rate_hz = dt_s.recip();
    let filter =
        LowPass::new(rate_hz, cutoff_hz).ok_or(TeachResultError::Cutoff { rate_hz, cutoff_hz })?;
    let mut most: f64 = 0.0;
    for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
        if link.joint == JointModel::Spherical {
            // A rotation has two quaternions. The one that is nearer to the previous row's quaternion is used.
            for row in 1..rows.len() {
                let dot: f64 = range.clone().map(|at| rows[row][at] * rows[row - 1][at]).sum();
                let sign = if dot < 0.0 { -1.0 } else { 1.0 };
                rows[row][range.clone()].iter_mut().for_each(|x| *x *= sign);
            }
        }
        for at in range.clone() {
            let before: Vec<f64> = rows.iter().map(|row| row[at]).collect();
            let mut signal = before.clone();
            filter.apply(&mut signal);
            for ((row, after), before) in rows.iter_mut().zip(signal).zip(before) {
                most = most.max((after - before).abs());
                row[at] = after;
            }
        }
        if link.joint == JointModel::Spherical {
            for row in rows.iter_mut() {
                let length = row[range.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
                row[range.clone()].iter_mut().for_each(|x| *x /= length);
            }
        }
    }
    Ok(most)
}

/// Returns the first row away from the first position, and the last row away from the last position; `None` if no joint
/// leaves its position.
fn moving(mechanism: &Mechanism, rows: &[Vec<f64>]) -> Option<(usize, usize)> {
    let mut least = Vec::new();
    for link in &mechanism.bodies {
        let rest = if matches!(link.joint, JointModel::Prismatic(_)) { REST_M } else { REST_RAD };
        // A quaternion changes by half the angle.
        let rest = if link.joint == JointModel::Spherical { 0.5 * rest } else { rest };
        least.extend(std::iter::repeat_n(rest, link.joint.kind().coordinate_count()));
    }
    let is_away = |row: &Vec<f64>, from: &Vec<f64>| {
        row.iter().zip(from).zip(&least).any(|((a, b), least)| (a - b).abs() > *least)
    };
    let (begin, end) = (rows.first()?, rows.last()?);
    let first = rows.iter().position(|row| is_away(row, begin))?;
    let last = rows.iter().rposition(|row| is_away(row, end))?;
    Some((first, last.max(first)))
}

/// Compares a motion with the path of a hand, `begin_s` after its beginning. Returns mean and largest distance over
/// all rows and coordinates, rad or m, and the coordinate and time of the largest.
///
/// # Errors
/// [`MotionError`] if it is not a motion of the rig.
pub fn compare_with_guide(
    mechanism: &Mechanism,
    motion: &RigMotion,
    guide: &GuideTrajectory,
    begin_s: f64,
) -> Result<([f64; 2], usize, f64), MotionError> {
    let curve = Curve::new(mechanism, motion)?;
    let (mut sum, mut count, mut most) = (0.0, 0.0, (0.0, 0, 0.0));
    let mut instant = Instant::default();
    for row in 0..motion.rows.len() {
        let time_s = row as f64 * motion.dt_s;
        curve.at(time_s, &mut instant);
        for (at, (is, led)) in instant.q.iter().zip(&guide.at(begin_s + time_s).q).enumerate() {
            let off = (is - led).abs();
            (sum, count) = (sum + off, count + 1.0);
            if off > most.0 {
                most = (off, at, time_s);
            }
        }
    }
    Ok(([sum / f64::max(count, 1.0), most.0], most.1, most.2))
}
