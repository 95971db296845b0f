//! A motion in metres and seconds, without gaps.

use crate::skeleton::{JointSample, Skeleton, forward_kinematics};

/// A motion of a skeleton, with a sample of every joint in every frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Clip {
    /// Short name for tables: the stem of the file.
    pub name: String,
    /// Skeleton of all frames.
    pub skeleton: Skeleton,
    /// Time from one frame to the next, in seconds.
    pub frame_time_s: f64,
    /// Samples: `frames[f][j]` is joint `j` in frame `f`.
    pub frames: Vec<Vec<JointSample>>,
}

impl Clip {
    /// Returns the frame rate, Hz.
    pub fn rate_hz(&self) -> f64 {
        self.frame_time_s.recip()
    }

    /// Returns the pose of every joint in frame `frame`, in the world frame.
    pub fn world_poses(&self, frame: usize) -> Vec<JointSample> {
        forward_kinematics(&self.skeleton, &self.frames[frame])
    }
}

/// Returns the joint that moves the body through space: the root, or its only child if the root is at rest in all
/// `clips`, and so on. In some recordings the root stays on the floor. All clips must have the same skeleton.
pub fn moving_root(clips: &[&Clip]) -> usize {
    let mut joint = 0;
    loop {
        let Some(first) = clips.first() else { return joint };
        let Some(child) = first.skeleton.only_child(joint) else { return joint };
        let mut samples = clips.iter().flat_map(|clip| &clip.frames).map(|frame| frame[joint]);
        let Some(sample) = samples.next() else { return joint };
        let stays = samples.all(|other| other == sample);
        let moves_below = clips.iter().any(|clip| {
            clip.frames
                .windows(2)
                .any(|pair| pair[0][child].position_m != pair[1][child].position_m)
        });
        if !(stays && moves_below) {
            return joint;
        }
        joint = child;
    }
}
