//! Efforts that a motion of a mechanism needs, by the core's inverse dynamics.

#[cfg(test)]
mod tests;

use sinew_batch::Batch;
pub use sinew_batch::LANES;
use sinew_core::coordinates::CoordinatesError;
use sinew_core::dynamics::{BodyMotion, inverse_dynamics};
use sinew_core::{GRAVITY_M_S2, JointTargets, Tree, TreeError, Wrench};

use super::{BODY_COUNT_MAX, Mechanism};

/// A calculator of efforts of a mechanism, with its buffers.
#[derive(Debug)]
pub struct InverseDynamics {
    tree: Box<Tree<BODY_COUNT_MAX>>,
    motion: Box<JointTargets<BODY_COUNT_MAX>>,
    scratch: Vec<BodyMotion>,
    wrenches: Vec<Wrench>,
    efforts: Vec<f32>,
    batch: Batch,
}

impl InverseDynamics {
    /// Creates a calculator for a mechanism. O(bodies).
    ///
    /// # Errors
    /// [`TreeError`] if the mechanism exceeds the core's capacity, or a number is invalid in f32.
    pub fn of(mechanism: &Mechanism) -> Result<Self, TreeError> {
        let tree = Box::new(mechanism.tree::<BODY_COUNT_MAX>()?);
        Ok(Self {
            motion: Box::new(JointTargets::rest(&tree)),
            scratch: vec![BodyMotion::default(); tree.len()],
            wrenches: vec![Wrench::ZERO; tree.len()],
            efforts: vec![0.0; tree.dof_count()],
            batch: Batch::new(tree.bodies()),
            tree,
        })
    }

    /// Returns the efforts along the dofs, N m or N, including rotors and without friction. Positions, speeds and
    /// accelerations are those of `sinew_core::coordinates`. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError`] if a slice has the wrong length, or a number is invalid.
    pub fn efforts(
        &mut self,
        q: &[f32],
        qd: &[f32],
        qdd: &[f32],
    ) -> Result<&[f32], CoordinatesError> {
        self.motion.set_coordinates(&self.tree, q, qd, qdd)?;
        let (states, accelerations) = (self.motion.states(), self.motion.accelerations());
        let (scratch, wrenches) = (&mut self.scratch, &mut self.wrenches);
        let bodies = self.tree.bodies();
        inverse_dynamics(bodies, states, accelerations, GRAVITY_M_S2, &[], scratch, wrenches);
        self.tree.efforts(states, wrenches, &mut self.efforts)?;
        Ok(&self.efforts)
    }

    /// Computes [`Self::efforts`] of several instants, with equal bits. Each slice contains the values of the first
    /// coordinate at all instants, then those of the next coordinate. O(n), and faster than computing one instant
    /// after the other.
    ///
    /// # Errors
    /// Returns the error of [`Self::efforts`] for the first instant that has an error.
    pub fn efforts_side_by_side(
        &mut self,
        q: &[[f32; LANES]],
        qd: &[[f32; LANES]],
        qdd: &[[f32; LANES]],
    ) -> Result<&[[f32; LANES]], CoordinatesError> {
        if !self.batch.takes([q, qd, qdd]) {
            // Computing one instant after the other finds the error.
            for lane in 0..LANES {
                let [q, qd, qdd] =
                    [q, qd, qdd].map(|of| of.iter().map(|lanes| lanes[lane]).collect::<Vec<f32>>());
                self.efforts(&q, &qd, &qdd)?;
            }
        }
        Ok(self.batch.efforts([q, qd, qdd]))
    }
}
