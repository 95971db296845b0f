//! The motion of the 18-body figure: what every clip becomes.

use glam::{DQuat, DVec3};
use sinew_core::Transform;

use crate::figure::{BODIES, BODY_COUNT};

/// A clip mapped on the figure, evenly sampled and filtered.
///
/// World frame: right-handed, y up, metres. Body frame `i` has its origin at joint `i`.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureMotion {
    /// The clip's name.
    pub name: String,
    /// Time from one frame to the next, in seconds.
    pub dt_s: f64,
    /// Position of joint `i` in the frame of body `i`'s parent; zero for the root.
    pub offset_m: [DVec3; BODY_COUNT],
    /// End of the segment in the frame of body `i`: the next joint along it, or the end of the head,
    /// hand or foot. It tells the body model how the segment lies. The pelvis ends up the trunk; in
    /// skeletons where the abdomen begins at the pelvis' own origin, both end at the thorax.
    pub segment_end_m: [DVec3; BODY_COUNT],
    /// World position of the pelvis in each frame.
    pub root_position_m: Vec<DVec3>,
    /// Rotation from body `i` to its parent (the pelvis: to the world) in each frame, unit.
    pub rotation: Vec<[DQuat; BODY_COUNT]>,
}

impl FigureMotion {
    /// World position of every joint in frame `frame`, in metres.
    pub fn world_positions_m(&self, frame: usize) -> [DVec3; BODY_COUNT] {
        let mut position_m = [self.root_position_m[frame]; BODY_COUNT];
        let mut rotation = self.rotation[frame];
        for (i, body) in BODIES.iter().enumerate() {
            if let Some(parent) = body.parent {
                position_m[i] = position_m[parent] + rotation[parent] * self.offset_m[i];
                rotation[i] = rotation[parent] * rotation[i];
            }
        }
        position_m
    }
    /// Poses of all joints in frame `frame` (the last one, beyond the end), each in its parent's frame, as
    /// the core takes them.
    pub fn joint_poses(&self, frame: usize) -> [Transform; BODY_COUNT] {
        let frame = frame.min(self.rotation.len() - 1);
        std::array::from_fn(|joint| {
            let position_m =
                if joint == 0 { self.root_position_m[frame] } else { self.offset_m[joint] };
            Transform::new(self.rotation[frame][joint].as_quat(), position_m.as_vec3())
        })
    }
}
