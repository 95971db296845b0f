//! The common torque supply of the joints' drives.

use sinew_core::JointStates;
use sinew_core::Tree;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::supply::TorqueSupply;
use sinew_core::tracker::Sharing;

use super::capacity::CAPACITY;
use super::controller::narrow;
use super::error::RunError;
use super::importance_weights::ImportanceWeights;

/// Creates the supply of a run. With sharing by importance, the weights are `(lᵢ / Iᵢ)²`, from the joints' levers
/// and the articulated inertias at their drives in the rest pose.
pub(super) fn make_supply(
    sharing: Sharing,
    supply_nm: f64,
    tree: &Tree<CAPACITY>,
    importance: &ImportanceWeights,
) -> Result<TorqueSupply<CAPACITY>, RunError> {
    let supply = TorqueSupply::new(tree, narrow(supply_nm))?;
    Ok(match sharing {
        Sharing::Uniform | Sharing::Accelerations => supply,
        Sharing::Importance => supply.with_weights(&weights(tree, importance.as_slice_m()))?,
    })
}

/// Returns `(lᵢ / Iᵢ)²` for each joint: the squared change of the skin's acceleration per missing newton metre. The
/// joint's acceleration changes by `1 / I`, and the skin's acceleration by the lever times this.
fn weights(tree: &Tree<CAPACITY>, levers_m: &[f64]) -> Vec<f32> {
    let inertias = reflected_inertia(tree, &JointStates::rest(tree), OuterJoints::Free);
    let weight = |(inertia, lever_m): (&ReflectedInertia, &f64)| {
        let mean_kg_m2 = mean_moment_kg_m2(inertia);
        // A joint that cannot turn needs no torque, and its weight has no effect.
        if mean_kg_m2 > 0.0 {
            let moved = lever_m / mean_kg_m2;
            // Clamped to the valid range of weights: a leaf whose mass is at its joint moves nothing.
            narrow(moved * moved).clamp(1e-12, 1e12)
        } else {
            1.0
        }
    };
    inertias.iter().zip(levers_m).map(weight).collect()
}

/// Returns the mean moment over the axes.
fn mean_moment_kg_m2(inertia: &ReflectedInertia) -> f64 {
    let m = inertia.angular_kg_m2;
    f64::from(m.xx + m.yy + m.zz) / 3.0
}
