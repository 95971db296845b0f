//! What was measured while a rig was led, as a motion: rest is cut, noise is taken out.

use sinew_mocap::filter::LowPass;
use sinew_retarget::feasibility::{Curve, Instant, MotionError, Performance as _, RigMotion};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

use super::GuideTrajectory;

/// A joint that is nearer than this to where it began, or ended, rests: half a degree; of a slide half a millimetre.
pub const REST_RAD: f64 = 0.008_726_6;
const REST_M: f64 = 0.5e-3;
/// So much rest is left at both ends, s.
const LEFT_S: f64 = 0.25;

/// Why there is no motion.
#[derive(Debug, Error)]
pub enum TeachResultError {
    /// Nobody led it.
    #[error("no joint moved by more than 0.5 deg: nothing was taught")]
    Rest,
    /// The frequency is too high.
    #[error(
        "--cutoff-hz: expected a frequency below half of the {rate_hz} rows a second, found {cutoff_hz} Hz"
    )]
    Cutoff {
        /// Rows a second.
        rate_hz: f64,
        /// What was asked for.
        cutoff_hz: f64,
    },
    /// No motion of the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// A motion that was shown by hand.
#[derive(Debug, Clone)]
pub struct TeachResult {
    /// The motion.
    pub motion: RigMotion,
    /// Rest that was cut: before and after, s.
    pub cut_s: [f64; 2],
    /// How far the low-pass has moved a coordinate at most, rad or m.
    pub smoothed: f64,
}

impl TeachResult {
    /// Of measured rows. `cutoff_hz`: of the low-pass, 0 for none; `rate_hz`: rows a second of the motion.
    ///
    /// # Errors
    /// [`TeachResultError`].
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

/// Takes noise out of all coordinates; says how far it has moved one at most.
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
            // Of the two quaternions of a rotation, the one near that of the row before.
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

/// The first row that is away from where it began, and the last that is away from where it ended.
fn moving(mechanism: &Mechanism, rows: &[Vec<f64>]) -> Option<(usize, usize)> {
    let mut least = Vec::new();
    for link in &mechanism.bodies {
        let rest = if matches!(link.joint, JointModel::Prismatic(_)) { REST_M } else { REST_RAD };
        // Half of the angle is what a quaternion shows of it.
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

/// How far a motion is from the way that a hand led, `begin_s` after its beginning: mean and largest over all rows and
/// coordinates, rad or m; and the coordinate and time of the largest.
///
/// # Errors
/// [`MotionError`] if it is none of the rig.
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
