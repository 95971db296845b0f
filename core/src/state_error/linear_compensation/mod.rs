//! Linear Compensation Error: bodies turn so that their child reaches its goal.

mod aims;
mod compensation;
mod least_squares;
mod one_goal;

pub use aims::{Aim, Aims, AimsError};
pub use compensation::{AimStatus, Compensation, RateTerm};
pub use least_squares::compensate_all;
pub use one_goal::compensate;

use super::StateError;
use crate::math;
use crate::state::BodyState;
use least_squares::Arms;
use one_goal::toward;

/// Computes the Linear Compensation Error of each body in world axes: eq. (6)-(10) of Notman et al. (2011). O(n).
///
/// `status` receives the treatment of each body's aim.
///
/// ```
/// use sinew_core::{BodyState, Transform, glam::Vec3};
/// use sinew_core::state_error::{Aim, AimStatus, Compensation, StateError, linear_compensation};
/// let at = |x, y| BodyState {
///     pose: Transform::from_translation(Vec3::new(x, y, 0.0)),
///     ..BodyState::WORLD
/// };
/// // A thigh and the knee below it. The measured hip is 0.1 m to the side.
/// let desired = [at(0.0, 0.9), at(0.0, 0.5)];
/// let measured = [at(0.1, 0.9), at(0.1, 0.5)];
/// let (mut errors, mut status) = ([StateError::ZERO; 2], [AimStatus::Leaf; 2]);
/// let aims = [Aim::Child(1), Aim::None];
/// let settings = Compensation::default();
/// linear_compensation(&aims, settings, &desired, &measured, &mut errors, &mut status);
/// // The thigh rotates inwards, which brings the knee nearer to its desired position.
/// assert_eq!(status, [AimStatus::Compensated, AimStatus::Leaf]);
/// assert!((errors[0].angular_rad.z + (0.1f32 / 0.4).atan()).abs() < 1e-6);
/// assert_eq!(errors[1].angular_rad, Vec3::ZERO);
/// ```
pub fn linear_compensation(
    aims: &[Aim],
    settings: Compensation,
    desired: &[BodyState],
    measured: &[BodyState],
    out: &mut [StateError],
    status: &mut [AimStatus],
) {
    for ((((aim, of_desired), of_measured), error), status) in
        aims.iter().zip(desired).zip(measured).zip(out).zip(status)
    {
        (*error, *status) = aimed(aim, settings, desired, of_desired, of_measured);
    }
}

/// Returns the Linear Compensation Error of a body, in world axes.
#[inline]
pub(crate) fn aimed(
    aim: &Aim,
    settings: Compensation,
    desired: &[BodyState],
    of_desired: &BodyState,
    of_measured: &BodyState,
) -> (StateError, AimStatus) {
    // z - p_d of eq. (6): the goal is the child's position in the *desired* figure. Only then does the method
    // minimise the child's own linear error, for any dimensions of the model.
    let arm_to = |child: usize| {
        let child = desired.get(child)?;
        Some(child.pose.translation_m - of_desired.pose.translation_m)
    };
    let goal_arm = match *aim {
        Aim::None => Err(AimStatus::Leaf),
        Aim::Child(child) => arm_to(child).ok_or(AimStatus::Leaf),
        Aim::Point(point) => Ok(math::rotate(of_desired.pose.rotation, point)),
        // All single goals share one call below, so that an image contains the inlined code only once.
        Aim::Children(children) => match Arms::new(children.iter().filter_map(arm_to)) {
            Arms::Without(status) => Err(status),
            Arms::Line(arm) => Ok(arm),
            Arms::Spread(arms) => {
                return arms.compensate(settings, of_desired, of_measured);
            }
        },
    };
    toward(goal_arm, settings, of_desired, of_measured)
}
