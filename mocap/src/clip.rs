//! A motion in metres and seconds, without gaps.

use crate::skeleton::{JointSample, Skeleton, forward_kinematics};

/// A motion of a skeleton, with a sample of every joint in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Short name for tables: the file's stem.
    pub name: String,
    /// The skeleton of all frames.
    pub skeleton: Skeleton,
    /// Time from one frame to the next, in seconds.
    pub frame_time_s: f64,
    /// `frames[f][j]`: joint `j` in frame `f`.
    pub frames: Vec<Vec<JointSample>>,
}

impl Clip {
    /// Frames per second.
    pub fn rate_hz(&self) -> f64 {
        self.frame_time_s.recip()
    }

    /// Pose of every joint in frame `frame`, in the world frame.
    pub fn world_poses(&self, frame: usize) -> Vec<JointSample> {
        forward_kinematics(&self.skeleton, &self.frames[frame])
    }
}
