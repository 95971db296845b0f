//! Blends the end of a motion into its beginning.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;
use thiserror::Error;

use super::check::check;
use super::curve::{Curve, align_quaternions};
use super::error::CheckError;
use super::limits::{DofLimits, Limits};
use super::motion::{MotionError, RigMotion};
use super::report::{Excess, Kind};
use super::rows::Rows;

/// Number of rows that give the speed and acceleration at an end: a parabola goes through them.
const END_ROWS: usize = 3;
/// Minimum squared length of a blended quaternion. A shorter one rotates more than three times as fast as its
/// numbers change.
const SHORTEST_SQUARED: f64 = 0.1;
/// Sampling rate of the check of a blend, Hz.
const CHECK_HZ: f64 = 200.0;

/// A motion that can be played in a loop.
#[derive(Debug, Clone, PartialEq)]
pub struct LoopedMotion {
    /// The motion. Its last row equals its first row.
    pub motion: RigMotion,
    /// Duration of the blend at the end, s.
    pub blend_s: f64,
    /// Body whose joint was changed most, and that change, rad or m. A driven base is left out.
    pub most: (usize, f64),
}

/// The reason why a motion cannot be looped.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum LoopError {
    /// The motion is invalid for the rig.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The check refused the rig or an instant.
    #[error(transparent)]
    Check(#[from] CheckError),
    /// The blend is too short or too long for the motion.
    #[error(
        "the blend into the beginning: expected from {least_s:.3} s to the {most_s:.3} s that the motion lasts, found \
         {found_s:.3} s"
    )]
    Blend {
        /// Requested duration, s.
        found_s: f64,
        /// Minimum duration, s: the rows that give the acceleration.
        least_s: f64,
        /// Maximum duration, s.
        most_s: f64,
    },
    /// The base ends too far from its start.
    #[error(
        "the base `{joint}` ends {way_m:.2} m from its start: to return within {blend_s:.2} s it would move at \
         {speed:.2} m/s, but the motion itself never moves it faster than {fastest:.2} m/s: use a longer blend, or a \
         base that does not travel"
    )]
    Travels {
        /// Name of the base's joint.
        joint: String,
        /// Distance of the base from its start, m.
        way_m: f64,
        /// Duration of the blend, s.
        blend_s: f64,
        /// Speed of the return, m/s.
        speed: f64,
        /// Maximum speed of the motion itself, m/s.
        fastest: f64,
    },
    /// A ball joint would rotate by about 180 deg or more.
    #[error(
        "`{joint}`: its orientation at the end is too far from that at the start, or turns too fast: a shorter blend \
         helps"
    )]
    Turns {
        /// Name of the joint.
        joint: String,
    },
    /// The blend exceeds a limit that the motion itself observes.
    #[error(
        "`{joint}`: to return to its start within {blend_s:.2} s, its {} becomes {}, and its limit is {}: use a longer \
         blend, or a fit",
        kind.name(),
        kind.shown(*slides, *value),
        kind.shown(*slides, *limit)
    )]
    Beyond {
        /// Name of the dof.
        joint: String,
        /// Whether the dof slides.
        slides: bool,
        /// Kind of limit.
        kind: Kind,
        /// Value in the blend.
        value: f64,
        /// Value of the limit.
        limit: f64,
        /// Duration of the blend, s.
        blend_s: f64,
    },
}

/// Blends the last `blend_s` of a motion into its first row: a quintic is added to each coordinate, so that
/// position, speed and acceleration become those of the beginning. Everything before the blend, and the duration,
/// are unchanged. A ball joint takes the shorter rotation. O(rows).
///
/// # Errors
/// [`LoopError`] if the motion is invalid for the rig, the blend is shorter than three rows or longer than the motion,
/// a base would have to return too fast, or a ball joint has no direct path.
pub fn looped(
    mechanism: &Mechanism,
    motion: &RigMotion,
    blend_s: f64,
) -> Result<LoopedMotion, LoopError> {
    motion.check(mechanism)?;
    let dt_s = motion.dt_s;
    let (least_s, most_s) = (END_ROWS as f64 * dt_s, motion.duration_s());
    // The comparison also refuses NaN. The tolerance of half a row is for rounding.
    if !(least_s - 0.5 * dt_s..=most_s + 0.5 * dt_s).contains(&blend_s) {
        return Err(LoopError::Blend { found_s: blend_s, least_s, most_s });
    }
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "within the rows")]
    let span = ((blend_s / dt_s).round() as usize).min(motion.rows.len() - 1);
    let ranges = mechanism.coordinate_ranges();
    let mut rows = Rows::of(mechanism.coordinate_count(), &motion.rows);
    align_quaternions(&ranges, &mut rows);
    let mut rows = rows.lists();
    let last = rows.len() - 1;
    let begin = &rows[..END_ROWS];
    let end: Vec<&Vec<f64>> = rows[last + 1 - END_ROWS..].iter().rev().collect();
    let mut steps: Vec<[f64; 3]> = (0..begin[0].len())
        .map(|k| {
            let [p0, v0, a0] = parabola([begin[0][k], begin[1][k], begin[2][k]]);
            // The parabola runs backwards in time, therefore its speed has the opposite sign.
            let [p1, v1, a1] = parabola([end[0][k], end[1][k], end[2][k]]);
            let rows = span as f64;
            [p0 - p1, (v0 + v1) * rows, (a0 - a1) * rows * rows]
        })
        .collect();
    for (link, range) in mechanism.bodies.iter().zip(&ranges).filter(|(_, range)| range.len() >= 4)
    {
        let turn = range.start..range.start + 4;
        let along: f64 = turn.clone().map(|k| rows[0][k] * rows[last][k]).sum();
        if along < 0.0 {
            // The other sign of the beginning's quaternion is the same rotation.
            for k in turn {
                let [p0, v0, a0] = parabola([rows[0][k], rows[1][k], rows[2][k]]);
                let rows = span as f64;
                let step = &mut steps[k];
                *step = [
                    step[0] - 2.0 * p0,
                    step[1] - 2.0 * v0 * rows,
                    step[2] - 2.0 * a0 * rows * rows,
                ];
            }
        }
        if link.joint == JointModel::Free {
            let joint = &link.joint_name;
            check_travel(joint, &motion.rows, range.start + 4..range.end, [dt_s, span as f64])?;
        }
    }
    let mut most = (0, 0.0);
    for (step, row) in rows[last + 1 - span..=last].iter_mut().enumerate() {
        let share = (step + 1) as f64 / span as f64;
        let given = std::mem::take(row);
        let mut now: Vec<f64> =
            given.iter().zip(&steps).map(|(x, step)| x + added(*step, share)).collect();
        for (body, (link, range)) in mechanism.bodies.iter().zip(&ranges).enumerate() {
            let change = if range.len() >= 4 {
                let turn = &mut now[range.start..range.start + 4];
                let squared: f64 = turn.iter().map(|x| x * x).sum();
                if squared < SHORTEST_SQUARED || squared.is_nan() {
                    return Err(LoopError::Turns { joint: link.joint_name.clone() });
                }
                for x in turn.iter_mut() {
                    *x /= libm::sqrt(squared);
                }
                let along: f64 = turn.iter().zip(&given[range.clone()]).map(|(a, b)| a * b).sum();
                2.0 * libm::acos(along.abs().min(1.0))
            } else {
                range.clone().map(|k| (now[k] - given[k]).abs()).fold(0.0, f64::max)
            };
            if link.joint != JointModel::Free && change > most.1 {
                most = (body, change);
            }
        }
        *row = now;
    }
    // The last row equals the first, except for last bits and signs of quaternions.
    let first = rows[0].clone();
    rows[last] = first;
    Ok(LoopedMotion { motion: RigMotion { dt_s, rows }, blend_s: span as f64 * dt_s, most })
}

impl LoopedMotion {
    /// Refuses a blend that exceeds a limit more than the given motion does anywhere. Heat is ignored, because it
    /// depends on the whole motion. O(rows · bodies).
    ///
    /// # Errors
    /// [`LoopError::Beyond`] names the first excess; [`LoopError::Motion`] and [`LoopError::Check`] if a motion cannot
    /// be checked.
    pub fn check(
        &self,
        mechanism: &Mechanism,
        limits: &Limits,
        given: &RigMotion,
    ) -> Result<(), LoopError> {
        let excesses = |motion| -> Result<Vec<Excess>, LoopError> {
            Ok(check(mechanism, limits, &Curve::new(mechanism, motion)?, CHECK_HZ)?.excesses)
        };
        let before = excesses(given)?;
        let beyond = |excess: &Excess| (excess.value - excess.limit).abs();
        let from_s = self.motion.duration_s() - self.blend_s;
        for excess in excesses(&self.motion)? {
            let Excess { dof, kind, to_s, value, limit, .. } = excess;
            let was = before.iter().filter(|was| (was.dof, was.kind) == (dof, kind));
            let is_new = was.fold(0.0, |most, was| f64::max(most, beyond(was))) < beyond(&excess);
            if is_new && to_s >= from_s && kind != Kind::Heat {
                let DofLimits { name, slides, .. } = &limits.dofs[dof];
                let (joint, slides, blend_s) = (name.clone(), *slides, self.blend_s);
                return Err(LoopError::Beyond { joint, slides, kind, value, limit, blend_s });
            }
        }
        Ok(())
    }
}

/// Refuses a base that would have to return faster than it ever moves. The last argument contains the time from row
/// to row, s, and the rows of the blend.
fn check_travel(
    joint: &str,
    rows: &[Vec<f64>],
    place: std::ops::Range<usize>,
    [dt_s, span]: [f64; 2],
) -> Result<(), LoopError> {
    let way = |from: &[f64], to: &[f64]| {
        libm::sqrt(place.clone().map(|k| (to[k] - from[k]).powi(2)).sum())
    };
    let fastest = rows.windows(2).map(|pair| way(&pair[0], &pair[1]) / dt_s).fold(0.0, f64::max);
    let (way_m, blend_s) = (way(&rows[0], &rows[rows.len() - 1]), span * dt_s);
    // The maximum speed of a quintic from rest to rest is 1.875 times its mean speed.
    let speed = 1.875 * way_m / blend_s;
    if speed > fastest {
        let joint = joint.to_owned();
        return Err(LoopError::Travels { joint, way_m, blend_s, speed, fastest });
    }
    Ok(())
}

/// Returns position, speed (per row) and acceleration (per row²) at the first of three rows.
fn parabola([a, b, c]: [f64; 3]) -> [f64; 3] {
    [a, (4.0 * b - 3.0 * a - c) / 2.0, a - 2.0 * b + c]
}

/// Returns the value, at a share of its duration, of the quintic that begins at zero at rest and ends with this
/// position, speed and acceleration.
fn added([p, v, a]: [f64; 3], share: f64) -> f64 {
    let x = share;
    let of_p = 10.0 + x * (6.0 * x - 15.0);
    let of_v = -4.0 + x * (7.0 - 3.0 * x);
    let of_a = 0.5 * (1.0 - x) * (1.0 - x);
    x * x * x * (p * of_p + v * of_v + a * of_a)
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};
    use sinew_rig::mechanism::Link;
    use sinew_rig::review::Servos;

    use super::*;

    const DT_S: f64 = 0.01;
    const BLEND_S: f64 = 0.8;

    /// Creates a rig of a driven base, a hinge and a ball.
    fn rig() -> Mechanism {
        let hinge = Link {
            joint_name: "hinge".into(),
            ranges: vec![[-2.0, 2.0]],
            speed: 3.0,
            ..Link::on(Some(0), JointModel::Revolute(DVec3::Z), DVec3::ZERO)
        };
        let ball = Link {
            joint_name: "ball".into(),
            ..Link::on(Some(1), JointModel::Spherical, DVec3::ZERO)
        };
        let base = Link::on(None, JointModel::Free, DVec3::ZERO);
        Mechanism { bodies: vec![base, hinge, ball], linked: vec![] }
    }

    /// Creates a motion of 2 s in which no joint returns to its start. `turns_rad_s` is the speed of the ball.
    fn motion(turns_rad_s: f64) -> RigMotion {
        let row = |row: i32| {
            let t = DT_S * f64::from(row);
            let base = DQuat::from_rotation_y(0.2 * libm::sin(t));
            let ball =
                DQuat::from_rotation_x(turns_rad_s * t) * DQuat::from_rotation_z(0.3 * t * t);
            let mut q = base.to_array().to_vec();
            q.extend([0.03 * libm::sin(3.0 * t), 0.9, 0.0]);
            q.push(0.3 * t + 0.5 * libm::sin(2.0 * t));
            q.extend(ball.to_array());
            q
        };
        RigMotion { dt_s: DT_S, rows: (0..=200).map(row).collect() }
    }

    #[test]
    fn a_loop_goes_on_in_position_speed_and_acceleration() {
        let (rig, given) = (rig(), motion(0.6));
        let looped = looped(&rig, &given, BLEND_S).unwrap();
        let rows = &looped.motion.rows;
        assert_eq!((rows.len(), rows.first()), (given.rows.len(), rows.last()));
        // Everything before the blend is unchanged.
        assert_eq!(rows[..=120], given.rows[..=120]);
        assert!((looped.blend_s - BLEND_S).abs() < 1e-12);
        // Backwards from the end, it is the parabola of the beginning.
        let last = rows.len() - 1;
        let span = BLEND_S / DT_S;
        for k in 0..rows[0].len() {
            let jet = |rows: &[Vec<f64>], at: [usize; 3]| parabola(at.map(|row| rows[row][k]));
            let [p0, v0, a0] = jet(rows, [0, 1, 2]);
            let [p1, v1, a1] = jet(rows, [last, last - 1, last - 2]);
            let [q1, w1, b1] = jet(&given.rows, [last, last - 1, last - 2]);
            // Tolerance from the third derivative of the added quintic. The speed of a one-sided parabola is wrong by a
            // third of this derivative, its acceleration by all of it. The margin is for the fourth derivative, a tenth
            // of the third per row. Normalizing quaternions changes speed and acceleration by a similar amount.
            let [p, v, a] = [p0 - q1, (v0 + w1) * span, (a0 - b1) * span * span];
            let third = (60.0 * p.abs() + 36.0 * v.abs() + 9.0 * a.abs()) / span.powi(3);
            let most = if (4..8).contains(&k) { third } else { 2.0 * third };
            assert!((p0 - p1).abs() < 1e-12, "{k}");
            assert!((v0 + v1).abs() <= 0.5 * most + 1e-12, "{k}: {v0} {v1} {most}");
            assert!((a0 - a1).abs() <= 1.5 * most + 1e-12, "{k}: {a0} {a1} {most}");
        }
        assert_eq!(looped.most.0, 2);
    }

    #[test]
    fn what_is_no_loop_is_refused_in_words() {
        let (rig, given) = (rig(), motion(0.6));
        for blend_s in [0.01, 2.1, f64::NAN, -1.0] {
            let told = looped(&rig, &given, blend_s).unwrap_err().to_string();
            assert!(told.contains("from 0.030 s to the 2.000 s"), "{told}");
        }
        let mut walks = given.clone();
        for (row, q) in walks.rows.iter_mut().enumerate() {
            q[4] = 0.01 * row as f64;
        }
        let told = looped(&rig, &walks, BLEND_S).unwrap_err().to_string();
        assert!(told.contains("2.00 m from its start") && told.contains("1.00 m/s"), "{told}");
        // Rotates from three quarters of 180 deg to 180 deg: the path back opposes its middle.
        let mut turned = given.clone();
        for (row, q) in turned.rows.iter_mut().enumerate() {
            let x = row as f64 / 200.0;
            let there = x * x * x * (10.0 + x * (6.0 * x - 15.0)) + 64.0 * (x * (1.0 - x)).powi(3);
            q[8..]
                .copy_from_slice(&DQuat::from_rotation_x(std::f64::consts::PI * there).to_array());
        }
        let turned = looped(&rig, &turned, 2.0).unwrap_err();
        assert_eq!(turned, LoopError::Turns { joint: "ball".into() });

        // 1.98 rad in 0.2 s is 19 rad/s; in 1.8 s the blend opposes the motion, and the sum is less than 3.
        let limits = Limits::of(&rig, &Servos::default());
        let mut fast = given.clone();
        for (row, q) in fast.rows.iter_mut().enumerate() {
            q[7] = 0.99 * libm::sin(0.005 * std::f64::consts::PI * (row as f64 - 100.0));
        }
        let of = |blend_s| {
            looped(&rig, &fast, blend_s).and_then(|looped| looped.check(&rig, &limits, &fast))
        };
        let told = of(0.2).unwrap_err().to_string();
        assert!(told.contains("`hinge`") && told.contains("its limit is 3.000 rad/s"), "{told}");
        assert_eq!(of(1.8), Ok(()));
    }
}
