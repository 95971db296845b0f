//! What is evaluated: motions, each with the rig that performs it.

use sinew_rig::Mechanism;

use super::error::RunError;
use super::setup::Setup;
use crate::figure::{FigureMotion, Root};
use crate::plant::Pose;

/// A motion, evenly sampled, and the rig that performs it in a setup.
///
/// Its dimensions may be others than the rig's: it is what the errors are measured against.
pub trait Take: Sync {
    /// What people call it.
    fn name(&self) -> &str;

    /// What people call the rig; `None` for the paper's figure.
    fn rig_name(&self) -> Option<&str> {
        None
    }

    /// Shows all numbers that the motion and its rig are made of, by which it is known again.
    fn numbers(&self, see: &mut dyn FnMut(&[f64]));

    /// Time from one frame to the next, s.
    fn dt_s(&self) -> f64;

    /// Number of frames.
    fn frame_count(&self) -> usize;

    /// The rig, as its controller knows it.
    ///
    /// # Errors
    /// [`RunError`] if there is none for this motion.
    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError>;

    /// Puts the poses of all joints in a frame (the last one, beyond the end) into `out`, each in its parent's frame,
    /// the root's in the world; by body of the rig.
    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>);
}

/// A clip on the figure, which is made from it: the setup says with which body model, and how its pelvis is held.
impl Take for FigureMotion {
    fn name(&self) -> &str {
        &self.name
    }

    fn numbers(&self, see: &mut dyn FnMut(&[f64])) {
        let vectors = self.offset_m.iter().chain(&self.segment_end_m).chain(&self.root_position_m);
        for vector in vectors {
            see(&vector.to_array());
        }
        for rotation in self.rotation.iter().flatten() {
            see(&rotation.to_array());
        }
    }

    fn dt_s(&self) -> f64 {
        self.dt_s
    }

    fn frame_count(&self) -> usize {
        self.rotation.len()
    }

    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError> {
        Ok(setup.model(self)?.mechanism(setup.root))
    }

    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>) {
        let pose = |(rotation, position_m)| Pose { rotation, position_m };
        out.clear();
        out.extend(self.joints(frame).map(pose));
        if setup.root == Root::Fixed
            && let (Some(root), Some(held)) = (out.first_mut(), self.joints(0).next())
        {
            *root = pose(held);
        }
    }
}

/// Motions of different kinds, side by side.
impl<T: Take + ?Sized> Take for Box<T> {
    fn name(&self) -> &str {
        self.as_ref().name()
    }

    fn rig_name(&self) -> Option<&str> {
        self.as_ref().rig_name()
    }

    fn numbers(&self, see: &mut dyn FnMut(&[f64])) {
        self.as_ref().numbers(see);
    }

    fn dt_s(&self) -> f64 {
        self.as_ref().dt_s()
    }

    fn frame_count(&self) -> usize {
        self.as_ref().frame_count()
    }

    fn mechanism(&self, setup: &Setup) -> Result<Mechanism, RunError> {
        self.as_ref().mechanism(setup)
    }

    fn joint_poses(&self, setup: &Setup, frame: usize, out: &mut Vec<Pose>) {
        self.as_ref().joint_poses(setup, frame, out);
    }
}
