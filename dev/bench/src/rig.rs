//! A rig and its tick, from poses to torques, as an application would call the core.

use sinew_core::control::Limited;
use sinew_core::{
    ForwardDifferences, JointStates, JointTargets, StateInputError, TorqueController, Transform,
    Workspace, Wrench,
};

/// Time between two frames, s.
pub const DT_S: f32 = 0.01;

/// A controller with all data of its tick; `R` is the room for resolved acceleration, see [`Workspace`].
#[derive(Debug)]
pub struct Rig<const N: usize, const R: usize = 0> {
    controller: TorqueController<N>,
    differences: ForwardDifferences<N>,
    targets: JointTargets<N>,
    measured: JointStates<N>,
    workspace: Workspace<N, R>,
}

impl<const N: usize, const R: usize> Rig<N, R> {
    /// Creates a controller's rig with the first two frames of the performance.
    ///
    /// # Errors
    /// [`StateInputError`] if a pose is missing, not finite or not unit.
    pub fn new(
        controller: TorqueController<N>,
        workspace: Workspace<N, R>,
        desired: [&[Transform]; 2],
    ) -> Result<Self, StateInputError> {
        let tree = controller.tree();
        let [first, second] = desired;
        let (mut differences, mut targets) = (ForwardDifferences::new(), JointTargets::rest(tree));
        differences.restart(tree, DT_S, first)?;
        differences.advance(tree, second, &mut targets)?;
        Ok(Self { differences, targets, measured: JointStates::rest(tree), controller, workspace })
    }

    /// Computes the torques for the next frame of the performance, and the present measured poses.
    ///
    /// # Errors
    /// [`StateInputError`] if a pose is missing, not finite or not unit.
    // A separate function, so that its stack can be distinguished from its caller's.
    #[inline(never)]
    pub fn tick(
        &mut self,
        desired: &[Transform],
        measured: &[Transform],
    ) -> Result<&[Limited<Wrench>], StateInputError> {
        self.differences.advance(self.controller.tree(), desired, &mut self.targets)?;
        self.measured.update_poses(measured, DT_S)?;
        Ok(self.controller.tick(&mut self.targets, &self.measured, &[], &mut self.workspace))
    }
}
