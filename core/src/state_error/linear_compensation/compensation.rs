//! Settings of Linear Compensation, what becomes of aims, and the error with a compensating rotation.

use glam::{Quat, Vec3};

use crate::state::BodyState;
use crate::state_error::StateError;

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

/// The treatment of a body's aim.
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

/// World error with the desired orientation turned by `turn`, and the rate of that turn, both weighted
/// with β: eq. (9) and (10).
#[expect(
    clippy::inline_always,
    reason = "a call would cost 60 more instructions per body, to pass values through memory"
)]
#[inline(always)]
pub(super) fn with_turn(
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
