//! What the drives of the joints have together.

use sinew_core::JointStates;
use sinew_core::Tree;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::supply::TorqueSupply;
use sinew_core::tracker::Sharing;

use super::controller::narrow;
use super::error::RunError;
use super::levers::Levers;
use super::setup::Setup;
use crate::figure::BODY_COUNT;

/// The supply of a run; by importance, with weights `(lᵢ / Iᵢ)²` of the joints' levers and of the articulated
/// inertias that their drives work against in the rest pose.
pub(super) fn supply(
    setup: &Setup,
    tree: &Tree<BODY_COUNT>,
    levers: &Levers,
) -> Result<TorqueSupply<BODY_COUNT>, RunError> {
    let supply = TorqueSupply::new(tree, narrow(setup.disturbance.supply_nm))?;
    Ok(match setup.controller.sharing {
        Sharing::Alike | Sharing::Accelerations => supply,
        Sharing::Importance => supply.with_weights(&weights(tree, levers))?,
    })
}

/// What a newton metre too few at a joint moves, squared: it accelerates what hangs there by `1 / I`, and the skin by
/// the lever of that.
fn weights(tree: &Tree<BODY_COUNT>, levers: &Levers) -> [f32; BODY_COUNT] {
    let inertias = reflected_inertia(tree, &JointStates::rest(tree), OuterJoints::Free);
    let mut weights = [1.0; BODY_COUNT];
    for ((weight, inertia), lever_m) in weights.iter_mut().zip(&inertias).zip(levers.as_array_m()) {
        let mean_kg_m2 = mean_moment_kg_m2(inertia);
        // A joint that cannot turn wants no torque, and its weight counts nothing.
        if mean_kg_m2 > 0.0 {
            let moved = lever_m / mean_kg_m2;
            // Within what weights may be: a leaf whose mass is at its joint moves nothing.
            *weight = narrow(moved * moved).clamp(1e-12, 1e12);
        }
    }
    weights
}

/// Mean over the axes.
fn mean_moment_kg_m2(inertia: &ReflectedInertia) -> f64 {
    let m = inertia.angular_kg_m2;
    f64::from(m.xx + m.yy + m.zz) / 3.0
}
