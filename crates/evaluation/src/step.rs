//! One step of a run.

use sinew_core::Transform;
use sinew_figure::plant::Pose;

use super::pose_error::PoseError;
use super::rig::Rig;
use super::setup::RigTracker;

/// One step of a run, after it was made: the rig at frame `frame`, in the world.
#[derive(Debug)]
pub struct Step<'a> {
    /// Frame of the motion that both sides are at.
    pub frame: usize,
    /// Where the bodies should be: the motion, in its own dimensions.
    pub desired: &'a [Pose],
    /// Where the plant has them.
    pub measured: &'a [Pose],
    /// How far each is off.
    pub errors: &'a [PoseError],
    /// The rig, as its controller knows it.
    pub rig: &'a Rig,
    /// How many joints were not given the torque they wanted.
    pub limited: usize,
    /// What the sensors gave the controller in the tick before, and in this one.
    pub readings: [&'a [Transform]; 2],
    /// What has made the torques.
    pub tracker: &'a mut RigTracker,
}

impl Step<'_> {
    /// The widest gap between the two sides of a joint, in metres: what the plant's constraints let through.
    pub fn widest_gap_m(&self) -> f64 {
        let gaps_m = (0..self.rig.links().len()).map(|body| self.rig.gap_m(body, self.measured));
        gaps_m.fold(0.0, f64::max)
    }
}
