//! One rig and its tick, from poses to torques, as an application would call the core.

use sinew_core::control::Limited;
use sinew_core::trajectory::{backward_states, forward_targets_of_bodies};
use sinew_core::{
    Controller, JointStates, JointTargets, StateInputError, Transform, Workspace, Wrench,
};

/// Time from one frame to the next, s.
pub const DT_S: f32 = 0.01;

/// A controller and all that its tick works on.
#[derive(Debug)]
pub struct Rig<const N: usize> {
    controller: Controller<N>,
    targets: JointTargets<N>,
    measured: JointStates<N>,
    workspace: Workspace<N>,
}

impl<const N: usize> Rig<N> {
    /// A controller's rig at rest.
    pub fn new(controller: Controller<N>) -> Self {
        let tree = controller.tree();
        Self {
            targets: JointTargets::rest(tree),
            measured: JointStates::rest(tree),
            controller,
            workspace: Workspace::new(),
        }
    }

    /// Torques for the poses of the performance now, next and after that, and those measured before and now.
    ///
    /// # Errors
    /// [`StateInputError`] if a pose is missing, not finite or not unit.
    // A function of its own, so that its stack can be told from its caller's.
    #[inline(never)]
    pub fn tick(
        &mut self,
        desired: [&[Transform]; 3],
        measured: [&[Transform]; 2],
    ) -> Result<&[Limited<Wrench>], StateInputError> {
        forward_targets_of_bodies(self.controller.tree(), desired, DT_S, &mut self.targets)?;
        backward_states(measured, DT_S, &mut self.measured)?;
        Ok(self.controller.tick(&self.targets, &self.measured, &[], &mut self.workspace))
    }
}
