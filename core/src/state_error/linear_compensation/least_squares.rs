//! The turn that takes several points of a body as near to their goals as they can be together.

use glam::{Mat3, Quat, Vec3};

use super::compensation::{AimStatus, Compensation, with_turn};
use super::one_goal::{SHORTEST_AIM_M, SMALLEST_SINE, toward};
use crate::math;
use crate::matrix::outer;
use crate::state::BodyState;
use crate::state_error::StateError;

/// Points less wide apart than this share of their squared distances, as seen from the body's origin, are
/// on one line: 0.6 degrees between two children of the same distance. The turn about that line would be a
/// large answer to a difference that hardly counts.
const NARROWEST: f32 = 1e-4;

/// Two or three steps do for figures that are close, seven was the most in 10,000 random cases of any size:
/// the steps double the digits, and the best angle about each axis brings them near.
const MOST_STEPS: usize = 12;

/// In units of the largest curvature there can be.
const LIFTS: [f32; 5] = [0.01, 0.04, 0.16, 0.64, 2.56];

/// After a step as small as this the next one would be below f32 rounding.
const LAST_STEP_RAD: f32 = 1e-5;

/// Linear Compensation Error of one body that aims at several children, in world axes. `goal_arms_m` are
/// the `z_k - p_d`, from the desired origin to the goals, in world axes.
///
/// The turn Φ makes `Σ |p_m + Φ a_k - z_k|²` least (Wahba, "A Least Squares Estimate of Satellite
/// Attitude", 1965), `a_k` the arms. For one child that is [`compensate`](super::compensate) but for a turn about the
/// arm, so there, and where all children are on one line with the origin, it is that function that answers.
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{AimStatus, Compensation, compensate_all};
/// // Two hips below a pelvis that hangs 0.05 m too low: no turn brings both of them nearer.
/// let desired = BodyState { pose: Transform::from_translation(Vec3::Y * 0.05), ..BodyState::WORLD };
/// let hips = [Vec3::new(0.1, -0.1, 0.0), Vec3::new(-0.1, -0.1, 0.0)];
/// let settings = Compensation::default();
/// let (error, status) = compensate_all(hips.into_iter(), settings, &desired, &BodyState::WORLD);
/// assert_eq!(status, AimStatus::Parallel);
/// assert_eq!(error.angular_rad, Vec3::ZERO);
/// ```
pub fn compensate_all(
    goal_arms_m: impl Iterator<Item = Vec3>,
    settings: Compensation,
    desired: &BodyState,
    measured: &BodyState,
) -> (StateError, AimStatus) {
    match Arms::new(goal_arms_m) {
        Arms::Without(status) => toward(Err(status), settings, desired, measured),
        Arms::Line(arm) => toward(Ok(arm), settings, desired, measured),
        Arms::Spread(arms) => arms.compensate(settings, desired, measured),
    }
}

/// How the arms to a body's children lie.
pub(super) enum Arms {
    /// There are none, or so that no turn brings the children nearer.
    Without(AimStatus),
    /// On one line through the origin: only a turn across it counts, and it is that of this one arm.
    Line(Vec3),
    /// In a plane or in space.
    Spread(Spread),
}

/// All that the best turn depends on.
pub(super) struct Spread {
    /// `Σ a`, m.
    sum: Vec3,
    /// `Σ a aᵀ`, m².
    second_moment: Mat3,
}

impl Arms {
    pub(super) fn new(arms: impl Iterator<Item = Vec3>) -> Self {
        let (mut count, mut sum, mut second_moment) = (0u32, Vec3::ZERO, Mat3::ZERO);
        for arm in arms {
            count = count.saturating_add(1);
            sum += arm;
            second_moment += outer(arm, arm);
        }
        if count == 0 {
            return Self::Without(AimStatus::Leaf);
        }
        if count == 1 {
            return Self::Line(sum);
        }
        let squares = trace(second_moment);
        let shortest = SHORTEST_AIM_M * SHORTEST_AIM_M;
        if squares < shortest {
            // All of them: what has no length has no direction.
            return Self::Without(AimStatus::ZeroAim);
        }
        if !(squares * squares).is_finite() {
            return Self::Without(AimStatus::NotFinite);
        }
        // The second eigenvalue, if it is small: the second elementary symmetric function of the three over
        // the first.
        let m = second_moment;
        let across = (minor(m.x_axis.x, m.y_axis.y, m.x_axis.y)
            + minor(m.x_axis.x, m.z_axis.z, m.x_axis.z)
            + minor(m.y_axis.y, m.z_axis.z, m.y_axis.z))
            / squares;
        if across >= shortest.max(NARROWEST * squares) {
            return Self::Spread(Spread { sum, second_moment });
        }
        // Every column of the moment of a line has its direction; the longest has it best.
        let longer = |a: Vec3, b: Vec3| if b.dot(b) > a.dot(a) { b } else { a };
        let along = longer(longer(m.x_axis, m.y_axis), m.z_axis);
        let direction = along / math::length(along);
        let lever = sum.dot(direction);
        if lever * lever < SMALLEST_SINE * SMALLEST_SINE * squares {
            // Evenly to both sides of the origin.
            return Self::Without(AimStatus::Parallel);
        }
        Self::Line(direction * (squares / lever))
    }
}

impl Spread {
    /// The error of a body with such arms to its children, in world axes.
    pub(super) fn compensate(
        &self,
        settings: Compensation,
        desired: &BodyState,
        measured: &BodyState,
    ) -> (StateError, AimStatus) {
        let shift = desired.pose.translation_m - measured.pose.translation_m;
        let turn = match self.best_turn(shift) {
            Ok(turn) => turn,
            Err(status) => return (StateError::between(desired, measured), status),
        };
        let status =
            if turn == Quat::IDENTITY { AimStatus::Parallel } else { AimStatus::Compensated };
        let turn = math::exp(math::log(turn) * settings.beta);
        let shift_rate = desired.velocity.linear - measured.velocity.linear;
        let rate = self.turn_rate(shift_rate) * settings.beta;
        (with_turn(turn, rate, settings.rate_term, desired, measured), status)
    }

    /// The largest curvature that there can be, m².
    fn scale(&self, shift: Vec3) -> f32 {
        trace(self.second_moment) + math::length(shift) * math::length(self.sum)
    }

    /// The rotation Φ that makes `Σ |Φ a - (a + e)|²` least, `e` the desired less the measured origin; the
    /// identity if nothing is better, or why there is none: no way to better ones is the best, or f32 does not have
    /// the curvature's square.
    ///
    /// It makes `tr(Φᵀ B)` largest, `B = Σ (a + e) aᵀ`. About a unit axis n through angle θ that grows by
    /// `sin θ g·n - (1 - cos θ) n·H n`, with the slope `g = Σ (Φ a) × (a + e)` and the curvature
    /// `H = tr(B Φᵀ) 1 - sym(B Φᵀ)`: so each step takes the axis that Newton's method gives, and the very
    /// best angle about it. It never goes down, and has no second maximum to end at.
    fn best_turn(&self, shift: Vec3) -> Result<Quat, AimStatus> {
        let scale = self.scale(shift);
        if !(scale * scale).is_finite() {
            return Err(AimStatus::NotFinite);
        }
        let goals = self.second_moment + outer(shift, self.sum);
        let mut turn = Quat::IDENTITY;
        for _ in 0..MOST_STEPS {
            let now = goals * Mat3::from_quat(turn.conjugate());
            let slope = Vec3::new(
                now.y_axis.z - now.z_axis.y,
                now.z_axis.x - now.x_axis.z,
                now.x_axis.y - now.y_axis.x,
            );
            let curvature =
                Mat3::from_diagonal(Vec3::splat(trace(now))) - (now + now.transpose()) * 0.5;
            let newton = solve(curvature, SMALLEST_SINE * scale, slope);
            if math::length(slope) <= SMALLEST_SINE * scale {
                // At a saddle more than one way leads up, and none of them is better than the others.
                return newton.map(|_| turn).ok_or(AimStatus::Antiparallel);
            }
            // Far from the best rotation the curvature has to be lifted for a direction that leads up: by
            // little more than needed, or the steps get short. The last is enough for any.
            let lifted = || {
                LIFTS.iter().find_map(|lift| {
                    let lift = Mat3::from_diagonal(Vec3::splat(lift * scale));
                    solve(curvature + lift, SMALLEST_SINE * scale, slope)
                })
            };
            let way = newton.or_else(lifted).unwrap_or(slope);
            let axis = way / math::length(way);
            let angle = math::atan2(slope.dot(axis), axis.dot(curvature * axis));
            turn = math::unit(math::exp(axis * angle) * turn);
            if angle < LAST_STEP_RAD {
                break;
            }
        }
        Ok(turn)
    }

    /// Rate of the best turn where the linear error is small: `M φ = Σ a × e` there, with the curvature
    /// `M = Σ (|a|² 1 - a aᵀ)` at no turn.
    fn turn_rate(&self, shift_rate: Vec3) -> Vec3 {
        let squares = trace(self.second_moment);
        let curvature = Mat3::from_diagonal(Vec3::splat(squares)) - self.second_moment;
        solve(curvature, 0.0, self.sum.cross(shift_rate)).unwrap_or(Vec3::ZERO)
    }
}

fn trace(m: Mat3) -> f32 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Of the symmetric matrix with the diagonal `a`, `b`.
fn minor(a: f32, b: f32, off: f32) -> f32 {
    a * b - off * off
}

/// Solves `m x = b` for a symmetric matrix by its factors L D Lᵀ; none if a pivot is not above `floor`.
fn solve(m: Mat3, floor: f32, b: Vec3) -> Option<Vec3> {
    let (xx, xy, xz) = (m.x_axis.x, m.x_axis.y, m.x_axis.z);
    let (yy, yz, zz) = (m.y_axis.y, m.y_axis.z, m.z_axis.z);
    let d_x = xx;
    let (l_yx, l_zx) = (xy / d_x, xz / d_x);
    let d_y = yy - l_yx * xy;
    let rest = yz - l_zx * xy;
    let l_zy = rest / d_y;
    let d_z = zz - l_zx * xz - l_zy * rest;
    if !(d_x > floor && d_y > floor && d_z > floor) {
        return None;
    }
    let y = b.y - l_yx * b.x;
    let z = b.z - l_zx * b.x - l_zy * y;
    let z = z / d_z;
    let y = y / d_y - l_zy * z;
    Some(Vec3::new(b.x / d_x - l_yx * y - l_zx * z, y, z))
}
