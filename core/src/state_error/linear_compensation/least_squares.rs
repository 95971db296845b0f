//! The rotation that brings several points of a body as near to their goals as possible.

use glam::{Mat3, Quat, Vec3};

use super::compensation::{AimStatus, Compensation, with_turn};
use super::one_goal::{SHORTEST_AIM_M, SMALLEST_SINE, toward};
use crate::math;
use crate::matrix::outer;
use crate::state::BodyState;
use crate::state_error::StateError;

/// Minimum spread of points, as a share of their squared distances from the body's origin. Narrower points count as
/// collinear. For two children at the same distance, this minimum is an angle of 0.6 degrees. A rotation about their
/// line would be a large response to a negligible difference.
const NARROWEST: f32 = 1e-4;

/// Maximum number of Newton steps. Figures that are close need two or three; 10,000 random cases of any size needed
/// at most seven. The best angle about each axis brings the first steps near the solution; each further step
/// doubles the correct digits.
const MOST_STEPS: usize = 12;

/// Shifts that are added to the curvature matrix in turn until it is positive definite, in units of the largest
/// possible curvature.
const LIFTS: [f32; 5] = [0.01, 0.04, 0.16, 0.64, 2.56];

/// Last step, rad: after a step this small, the next step would be below f32 rounding.
const LAST_STEP_RAD: f32 = 1e-5;

/// Returns the Linear Compensation Error of a body that aims at several children, in world axes. `goal_arms_m`
/// contains the vectors `z_k - p_d` from the desired origin to the goals, in world axes.
///
/// The rotation Φ minimises `Σ |p_m + Φ a_k - z_k|²` (Wahba, "A Least Squares Estimate of Satellite Attitude", 1965),
/// with the arms `a_k`. For a single child, or if all children are on a line through the origin, the result is that
/// of [`compensate`](super::compensate), which leaves out the undefined rotation about the line.
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{AimStatus, Compensation, compensate_all};
/// // Two hips below a pelvis that is 0.05 m too low: no rotation brings both of them nearer.
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

/// The arrangement of the arms to a body's children.
pub(super) enum Arms {
    /// No arms, or arms for which no rotation brings the children nearer.
    Without(AimStatus),
    /// Arms on a line through the origin. They are equivalent to this single arm, because a rotation about the line
    /// moves no child.
    Line(Vec3),
    /// Arms in a plane or in space.
    Spread(Spread),
}

/// The sums that determine the best rotation.
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
            // The sum covers all arms: an arm without length has no direction.
            return Self::Without(AimStatus::ZeroAim);
        }
        if !(squares * squares).is_finite() {
            return Self::Without(AimStatus::NotFinite);
        }
        // The second eigenvalue, if it is small: the second elementary symmetric function of the eigenvalues divided
        // by the first.
        let m = second_moment;
        let across = (minor(m.x_axis.x, m.y_axis.y, m.x_axis.y)
            + minor(m.x_axis.x, m.z_axis.z, m.x_axis.z)
            + minor(m.y_axis.y, m.z_axis.z, m.y_axis.z))
            / squares;
        if across >= shortest.max(NARROWEST * squares) {
            return Self::Spread(Spread { sum, second_moment });
        }
        // Every column of a line's moment has its direction; the longest column is the most accurate.
        let longer = |a: Vec3, b: Vec3| if b.dot(b) > a.dot(a) { b } else { a };
        let along = longer(longer(m.x_axis, m.y_axis), m.z_axis);
        let direction = along / math::length(along);
        let lever = sum.dot(direction);
        if lever * lever < SMALLEST_SINE * SMALLEST_SINE * squares {
            // The arms balance about the origin.
            return Self::Without(AimStatus::Parallel);
        }
        Self::Line(direction * (squares / lever))
    }
}

impl Spread {
    /// Returns the error of a body with these arms to its children, in world axes.
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

    /// Returns the largest possible curvature, m².
    fn scale(&self, shift: Vec3) -> f32 {
        trace(self.second_moment) + math::length(shift) * math::length(self.sum)
    }

    /// Returns the rotation Φ that minimises `Σ |Φ a - (a + e)|²`, with `e` the desired minus the measured origin. The
    /// result is the identity if no rotation is better. Returns an error if several rotations are equally good, or the
    /// square of the curvature overflows f32.
    ///
    /// Φ maximises `tr(Φᵀ B)`, `B = Σ (a + e) aᵀ`. A rotation about a unit axis n through an angle θ increases it by
    /// `sin θ g·n - (1 - cos θ) n·H n`, with the slope `g = Σ (Φ a) × (a + e)` and the curvature
    /// `H = tr(B Φᵀ) 1 - sym(B Φᵀ)`. Each step therefore takes the axis of Newton's method, and the exactly best
    /// angle about it. The value never decreases, and there is no second maximum to end at.
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
                // At a saddle, several directions lead up, and none is better than the others.
                return newton.map(|_| turn).ok_or(AimStatus::Antiparallel);
            }
            // Far from the best rotation, the curvature must be shifted to get a direction that leads up. The first
            // shift that suffices is used, because larger shifts make the steps shorter. The last shift suffices in
            // all cases.
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

    /// Returns the rate of the best rotation for a small linear error: there `M φ = Σ a × e`, with the curvature
    /// `M = Σ (|a|² 1 - a aᵀ)` at the identity.
    fn turn_rate(&self, shift_rate: Vec3) -> Vec3 {
        let squares = trace(self.second_moment);
        let curvature = Mat3::from_diagonal(Vec3::splat(squares)) - self.second_moment;
        solve(curvature, 0.0, self.sum.cross(shift_rate)).unwrap_or(Vec3::ZERO)
    }
}

fn trace(m: Mat3) -> f32 {
    m.x_axis.x + m.y_axis.y + m.z_axis.z
}

/// Returns the determinant of the symmetric matrix with the diagonal `a`, `b`.
fn minor(a: f32, b: f32, off: f32) -> f32 {
    a * b - off * off
}

/// Solves `m x = b` for a symmetric matrix by its factors L D Lᵀ. Returns `None` if a pivot is not above `floor`.
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
