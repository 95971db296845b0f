//! Linear Compensation Error: bodies turn so that their child reaches its goal.

mod aims;
mod least_squares;
mod one_goal;

pub use aims::{Aim, Aims, AimsError};
pub use least_squares::compensate_all;
pub use one_goal::compensate;

use glam::{Quat, Vec3};

use super::StateError;
use crate::math;
use crate::state::BodyState;
use least_squares::Arms;
use one_goal::toward;

/// How strongly, and with which rate term, Linear Compensation acts.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Compensation {
    /// β of eq. (9): 0 is World Space Error exactly, 1 the paper's method.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub beta: f32,
    /// The derivative of the compensating rotation.
    pub rate_term: RateTerm,
}

impl Default for Compensation {
    /// β = 1 with the corrected rate.
    fn default() -> Self {
        Self { beta: 1.0, rate_term: RateTerm::default() }
    }
}

/// The extra term of the angular rate in eq. (10).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum RateTerm {
    /// `β (z - p_d) × ė_lin / d²`: the rate of the rotation that is really applied, to first order in
    /// the linear error. For several children `β M⁻¹ (Σ aₖ × ė_lin)`, `M = Σ (|aₖ|² 1 - aₖ aₖᵀ)` with
    /// their arms `aₖ`.
    #[default]
    Corrected,
    /// `β ė_lin × (z - p_d) / d²`: the sign as the paper prints it, which fits rotations of the other
    /// sense (for several children likewise). For comparison.
    AsPrinted,
    /// No extra term.
    None,
}

/// What happened to a body's aim.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
#[non_exhaustive]
pub enum AimStatus {
    /// A leaf: World Space Error.
    #[default]
    Leaf,
    /// Compensated.
    Compensated,
    /// The child lies in the desired direction already, several children are as near as they can be: no
    /// rotation, but its rate.
    Parallel,
    /// The measured origin is beyond the goal: the shortest rotation is half a turn about no particular
    /// axis (for several children: no one rotation is the best), and a figure must not jump: World Space
    /// Error.
    Antiparallel,
    /// The measured origin is at the goal, no direction leads there: World Space Error.
    Coincident,
    /// The child sits (all children sit) almost at the body's origin, the direction is noise: World Space
    /// Error.
    ZeroAim,
    /// The goal is so far away that f32 does not have what is computed of the distance (its square; for several
    /// children the fourth power), or no number: World Space Error.
    NotFinite,
}

/// Linear Compensation Error of each body in world axes: eq. (6)-(10) of Notman et al. (2011). O(n).
///
/// `status` tells what became of each body's aim.
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
/// // The thigh turns inwards, so that the knee comes nearer to where it should be.
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

/// Linear Compensation Error of one body, in world axes.
#[inline]
pub(crate) fn aimed(
    aim: &Aim,
    settings: Compensation,
    desired: &[BodyState],
    of_desired: &BodyState,
    of_measured: &BodyState,
) -> (StateError, AimStatus) {
    // z - p_d of eq. (6): the goal is where the *desired* figure has the child. Only then is the child's own linear
    // error what is minimised, whatever the model's dimensions.
    let arm_to = |child: usize| {
        let child = desired.get(child)?;
        Some(child.pose.translation_m - of_desired.pose.translation_m)
    };
    let goal_arm = match *aim {
        Aim::None => Err(AimStatus::Leaf),
        Aim::Child(child) => arm_to(child).ok_or(AimStatus::Leaf),
        Aim::Point(point) => Ok(math::rotate(of_desired.pose.rotation, point)),
        // One place for a single goal, whatever it is of: images hold what is in line once.
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

/// World error with the desired orientation turned by `turn`, and the rate of that turn, both weighted
/// with β: eq. (9) and (10).
#[expect(
    clippy::inline_always,
    reason = "as a call it costs 60 instructions a body, that go through memory"
)]
#[inline(always)]
fn with_turn(
    turn: Quat,
    rate_rad_s: Vec3,
    rate_term: RateTerm,
    desired: &BodyState,
    measured: &BodyState,
) -> StateError {
    let mut error = StateError::to_rotation(turn * desired.pose.rotation, desired, measured);
    error.angular_rate_rad_s += match rate_term {
        RateTerm::Corrected => rate_rad_s,
        RateTerm::AsPrinted => -rate_rad_s,
        RateTerm::None => Vec3::ZERO,
    };
    error
}
