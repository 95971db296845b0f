//! Converts poses of telemetry to evenly spaced rows.

use sinew_board_client::TimedPose;
use sinew_retarget::feasibility::RigMotion;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

/// Longest allowed time without a pose, s: half a period of 6 Hz, a frequency that the low-pass filter keeps. The
/// motion of the hand in a longer gap is unknown.
const LONGEST_GAP_S: f64 = 1.0 / 12.0;

/// Error of poses that are not a motion.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ReceivedError {
    /// Fewer than two complete poses were received.
    #[error("the controller sent {0} complete pose(s): a motion needs two")]
    Few(usize),
    /// There is a gap between poses.
    #[error(
        "no pose arrived for {gap_s:.2} s, {at_s:.2} s after the beginning (at most {LONGEST_GAP_S:.2} s are allowed): \
         the motion in between is not known; use a shorter cable, or a faster line"
    )]
    Gap {
        /// Length of the gap, s.
        gap_s: f64,
        /// Start of the gap, s.
        at_s: f64,
    },
}

/// Returns a motion through the complete poses, a row every `dt_s`, with linear interpolation. `tick_s`: length of a
/// controller's tick.
///
/// # Errors
/// [`ReceivedError`] if there are too few poses, or a gap is too long.
pub fn rows(
    mechanism: &Mechanism,
    poses: &[TimedPose],
    tick_s: f64,
    dt_s: f64,
) -> Result<RigMotion, ReceivedError> {
    let width = mechanism.coordinate_count();
    let whole: Vec<&TimedPose> = poses.iter().filter(|pose| pose.q.len() == width).collect();
    let [first, .., last] = whole.as_slice() else { return Err(ReceivedError::Few(whole.len())) };
    // The number of a tick may wrap to 0.
    let since_s = |pose: &TimedPose| f64::from(pose.tick.wrapping_sub(first.tick)) * tick_s;
    for pair in whole.windows(2) {
        let (at_s, gap_s) = (since_s(pair[0]), since_s(pair[1]) - since_s(pair[0]));
        if gap_s > LONGEST_GAP_S {
            return Err(ReceivedError::Gap { gap_s, at_s });
        }
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let count = (since_s(last) / dt_s).floor() as usize + 1;
    let mut next = 1;
    let row = |index: usize| {
        let time_s = index as f64 * dt_s;
        while next + 1 < whole.len() && since_s(whole[next]) < time_s {
            next += 1;
        }
        let (from, to) = (whole[next - 1], whole[next]);
        let (from_s, to_s) = (since_s(from), since_s(to));
        let share = if to_s > from_s { (time_s - from_s) / (to_s - from_s) } else { 1.0 };
        between(mechanism, &from.q, &to.q, share.clamp(0.0, 1.0))
    };
    Ok(RigMotion { dt_s, rows: (0..count).map(row).collect() })
}

/// Interpolates linearly between two poses.
fn between(mechanism: &Mechanism, from: &[f32], to: &[f32], share: f64) -> Vec<f64> {
    let mut q: Vec<f64> = Vec::with_capacity(from.len());
    for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
        let [from, to] = [from, to].map(|pose| pose[range.clone()].iter().copied().map(f64::from));
        let turns = matches!(link.joint, JointModel::Spherical | JointModel::Free);
        let dot: f64 = from.clone().zip(to.clone()).take(4).map(|(a, b)| a * b).sum();
        // The nearer of the two quaternions of a rotation.
        let sign = if turns && dot < 0.0 { -1.0 } else { 1.0 };
        let begin = q.len();
        q.extend(from.zip(to).enumerate().map(|(at, (a, b))| {
            let b = if at < 4 { sign * b } else { b };
            a + share * (b - a)
        }));
        if turns && let Some(turn) = q[begin..].first_chunk_mut::<4>() {
            let length = turn.iter().map(|x| x * x).sum::<f64>().sqrt();
            for x in turn {
                *x /= length;
            }
        }
    }
    q
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use sinew_rig::mechanism::Link;

    use super::*;

    fn rig() -> Mechanism {
        let hinge = Link::on(None, JointModel::Revolute(DVec3::Z), DVec3::ZERO);
        let ball = Link::on(Some(0), JointModel::Spherical, DVec3::ZERO);
        Mechanism { bodies: vec![hinge, ball], linked: vec![] }
    }

    fn pose(tick: u32, angle: f32) -> TimedPose {
        TimedPose { tick, q: vec![angle, 0.0, 0.0, 0.0, 1.0] }
    }

    #[test]
    fn a_lost_pose_is_bridged_and_ticks_may_begin_at_0_again() {
        let last = u32::MAX - 4;
        let mut poses = [pose(last, 0.0), pose(last.wrapping_add(5), 0.5), pose(5, 1.5)];
        // The other quaternion of the same rotation.
        poses[1].q[4] = -1.0;
        let motion = rows(&rig(), &poses, 0.002, 0.005).unwrap();
        let angles: Vec<f64> = motion.rows.iter().map(|row| row[0]).collect();
        let expected = [0.0, 0.25, 0.5, 1.0, 1.5];
        assert!(angles.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{angles:?}");
        assert_eq!(angles.len(), expected.len());
        assert!(motion.rows.iter().all(|row| row[4].abs() > 0.999), "{:?}", motion.rows);
        assert_eq!(motion.check(&rig()), Ok(()));
    }

    #[test]
    fn what_nobody_knows_is_refused() {
        const TICK_S: f64 = 1.0 / 64.0;
        let cut = TimedPose { tick: 1, q: vec![0.0] };
        assert_eq!(rows(&rig(), &[pose(0, 0.0), cut], TICK_S, 0.01), Err(ReceivedError::Few(1)));
        let gap = rows(&rig(), &[pose(0, 0.0), pose(2, 0.1), pose(10, 1.0)], TICK_S, 0.01);
        assert_eq!(gap, Err(ReceivedError::Gap { gap_s: 0.125, at_s: 0.03125 }));
    }
}
