//! One step of a run.

use sinew_core::Transform;
use sinew_figure::plant::Pose;

use super::pose_error::PoseError;
use super::rig::Rig;
use super::setup::RigTracker;

/// One step of a run, after its completion: the rig at frame `frame`, in the world.
#[derive(Debug)]
pub struct Step<'a> {
    /// Frame at which the motion and the plant are compared.
    pub frame: usize,
    /// Desired poses of the bodies: the motion, in its own dimensions.
    pub desired: &'a [Pose],
    /// Poses of the bodies in the plant.
    pub measured: &'a [Pose],
    /// Errors of the bodies.
    pub errors: &'a [PoseError],
    /// The rig, as its controller knows it.
    pub rig: &'a Rig,
    /// Number of joints that did not receive their desired torque.
    pub limited: usize,
    /// Sensor readings for the controller in the previous tick and in this tick.
    pub readings: [&'a [Transform]; 2],
    /// The tracker that computed the torques; `None` if those of several runs were computed together.
    pub tracker: Option<&'a mut RigTracker>,
}

impl Step<'_> {
    /// Returns the widest gap between the two sides of a joint, in metres. A gap is a defect of the plant's
    /// constraints.
    pub fn widest_gap_m(&self) -> f64 {
        let gaps_m = (0..self.rig.links().len()).map(|body| self.rig.gap_m(body, self.measured));
        gaps_m.fold(0.0, f64::max)
    }
}
