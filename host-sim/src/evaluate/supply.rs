//! What the drives of the joints have together, and how they share it.

use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::supply::TorqueSupply;
use sinew_core::{Controller, JointStates, Tree, Workspace, Wrench};

use super::controller::{SharingName, narrow};
use super::error::RunError;
use super::levers::Levers;
use super::setup::Setup;
use crate::figure::BODY_COUNT;

/// The supply of a run, and the rule by which it is shared.
pub(super) struct Supply {
    supply: TorqueSupply<BODY_COUNT>,
    sharing: SharingName,
}

impl Supply {
    pub(super) fn new(
        setup: &Setup,
        tree: &Tree<BODY_COUNT>,
        levers: &Levers,
    ) -> Result<Self, RunError> {
        let supply = TorqueSupply::new(tree, narrow(setup.disturbance.supply_nm))?;
        let sharing = setup.effective_controller().sharing;
        let supply = match sharing {
            SharingName::Alike | SharingName::Accelerations => supply,
            SharingName::Importance => supply.with_weights(&weights(tree, levers))?,
        };
        Ok(Self { supply, sharing })
    }

    /// Cuts what the last tick asked for to what there is.
    pub(super) fn share<const R: usize>(
        &self,
        controller: &Controller<BODY_COUNT>,
        states: &JointStates<BODY_COUNT>,
        workspace: &mut Workspace<BODY_COUNT, R>,
    ) {
        if self.sharing == SharingName::Accelerations && self.supply.supply_nm().is_finite() {
            let mut carried = [Wrench::ZERO; BODY_COUNT];
            controller.bias_wrenches(states, &[], workspace, &mut carried);
            self.supply.share_acceleration(workspace.torques_mut(), &carried);
        } else {
            self.supply.share(workspace.torques_mut());
        }
    }
}

/// What a newton metre too few at a joint moves, squared: it accelerates what hangs there by `1 / I`, and the skin by the
/// lever of that.
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
