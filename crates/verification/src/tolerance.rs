//! Limits of f64 results without a running error bound: derived from the number of steps, or from an iteration's
//! tolerance.

use sinew_pose_metrics::geodesic::Options;

use super::rounding::LAMBDA;

/// Relative limit for volume, centre and inertia of solids: fewer than 90 steps on either side, without a
/// difference of similar numbers. A rounding has the standard deviation of half a unit in the last place divided
/// by √3; the root of 180 is below 13.5, that of 3 above 1.73.
pub(super) const SOLID: f64 = LAMBDA * (f64::EPSILON / 2.0) * 13.5 / 1.73;

/// Assumed ratio of the largest to the smallest curvature of an energy, for the limits below. The lengths of a
/// figure's limbs differ by a factor of about ten, which enters squared, and a chain of limbs adds as much again.
const CONDITION: f64 = 1e3;

/// Returns the limit for positions on geodesics and their lengths, relative to the length. The iteration ends when
/// the gradient is [`Options::tolerance`](sinew_pose_metrics::geodesic::Options) of the energy, in the direction
/// of smallest curvature.
pub(super) fn geodesic_path() -> f64 {
    CONDITION * Options::default().tolerance
}

/// Returns the limit for the excess of a geodesic's energy over the golden energy, relative to the energy. At a
/// minimum the error of the poses enters squared.
pub(super) fn geodesic_energy() -> f64 {
    geodesic_path().powi(2) + SOLID
}
