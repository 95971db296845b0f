//! Settings of Linear Compensation, the treatment of aims, and the error with a compensating rotation.

use glam::{Quat, Vec3};

use crate::state::BodyState;
use crate::state_error::StateError;

/// Strength and rate term of Linear Compensation.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Compensation {
    /// Weight β of eq. (9): 0 is exactly World Space Error, 1 the paper's method.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub beta: f32,
    /// Rate of the compensating rotation.
    pub rate_term: RateTerm,
}

impl Default for Compensation {
    /// Returns β = 1 with the corrected rate.
    fn default() -> Self {
        Self { beta: 1.0, rate_term: RateTerm::default() }
    }
}

/// The additional term of the angular rate in eq. (10).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum RateTerm {
    /// `β (z - p_d) × ė_lin / d²`: the rate of the rotation that is actually applied, to first order in the linear
    /// error. For several children with arms `aₖ`: `β M⁻¹ (Σ aₖ × ė_lin)`, `M = Σ (|aₖ|² 1 - aₖ aₖᵀ)`.
    #[default]
    Corrected,
    /// `β ė_lin × (z - p_d) / d²`: the sign as printed in the paper, which fits rotations in the opposite sense
    /// (the same applies to several children). Use it only for comparison.
    AsPrinted,
    /// No additional term.
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
    /// The body is a leaf: World Space Error is used.
    #[default]
    Leaf,
    /// A body with a compensating rotation.
    Compensated,
    /// The child is already in the desired direction, or several children are as near as possible. The rotation is
    /// zero, but its rate is used.
    Parallel,
    /// The measured origin is beyond the goal: the shortest rotation is a half turn about an undefined axis (for
    /// several children: no rotation is the single best). A figure must not jump, so World Space Error is used.
    Antiparallel,
    /// The measured origin is at the goal, which gives no direction: World Space Error is used.
    Coincident,
    /// The child (or every child) is almost at the body's origin, and the direction would be noise: World Space Error
    /// is used.
    ZeroAim,
    /// The goal is not finite, or too distant for f32 (the square of the distance overflows; for several children the
    /// fourth power): World Space Error is used.
    NotFinite,
}

/// Returns the world error with the desired orientation rotated by `turn`, and the rate of that rotation, both
/// already weighted with β: eq. (9) and (10).
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
