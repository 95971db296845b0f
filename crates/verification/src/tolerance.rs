//! Limits of what is computed in f64, for which there is no running bound: by the number of steps, or by what an
//! iteration promises.

use sinew_pose_metrics::geodesic::Options;

use super::rounding::LAMBDA;

/// Volume, centre and inertia of solids, over each number: less than 90 steps on either side, with no difference of
/// like numbers among them. A rounding has the standard deviation of half a unit in the last place over √3; the root of
/// 180 is below 13.5, that of 3 above 1.73.
pub(super) const SOLID: f64 = LAMBDA * (f64::EPSILON / 2.0) * 13.5 / 1.73;

/// How many times less an energy may bend in one direction than in another for the promises below: in the lengths of a
/// figure's limbs it is some ten times, squared, and as much again for a chain of them.
const CONDITION: f64 = 1e3;

/// Positions on geodesics, and their lengths, over the length: the iteration ends where the gradient is
/// [`Options::tolerance`](sinew_pose_metrics::geodesic::Options) of the energy, in the direction in which that bends least.
pub(super) fn geodesic_path() -> f64 {
    CONDITION * Options::default().tolerance
}

/// By how much the energy of a geodesic may be above the golden one, over the energy: at a minimum, what its poses are
/// off by counts squared.
pub(super) fn geodesic_energy() -> f64 {
    geodesic_path().powi(2) + SOLID
}
