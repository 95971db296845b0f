//! What the drives of the joints have together.

use sinew_core::JointStates;
use sinew_core::Tree;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::supply::TorqueSupply;
use sinew_core::tracker::Sharing;

use super::capacity::CAPACITY;
use super::controller::narrow;
use super::error::RunError;
use super::importance_weights::ImportanceWeights;

/// Makes the supply of a run; by importance, with weights `(lᵢ / Iᵢ)²` of the joints' levers and of the articulated
/// inertias that their drives work against in the rest pose.
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

/// What a newton metre too few at a joint moves, squared: it accelerates what hangs there by `1 / I`, and the skin by
/// the lever of that.
fn weights(tree: &Tree<CAPACITY>, levers_m: &[f64]) -> Vec<f32> {
    let inertias = reflected_inertia(tree, &JointStates::rest(tree), OuterJoints::Free);
    let weight = |(inertia, lever_m): (&ReflectedInertia, &f64)| {
        let mean_kg_m2 = mean_moment_kg_m2(inertia);
        // A joint that cannot turn wants no torque, and its weight counts nothing.
        if mean_kg_m2 > 0.0 {
            let moved = lever_m / mean_kg_m2;
            // Within what weights may be: a leaf whose mass is at its joint moves nothing.
            narrow(moved * moved).clamp(1e-12, 1e12)
        } else {
            1.0
        }
    };
    inertias.iter().zip(levers_m).map(weight).collect()
}

/// Mean over the axes.
fn mean_moment_kg_m2(inertia: &ReflectedInertia) -> f64 {
    let m = inertia.angular_kg_m2;
    f64::from(m.xx + m.yy + m.zz) / 3.0
}
