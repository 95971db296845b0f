//! The clip as the controller, the plant and the measurement of errors take it.

use glam::{DQuat, DVec3};
use sinew_core::Transform;
use sinew_core::tracker::before_the_first;

use crate::figure::{BODIES, BODY_COUNT, FigureMotion, Root};
use crate::plant::{MovingPose, Pose};

/// A clip, performed with the pelvis moving or fixed.
#[derive(Debug, Clone, Copy)]
pub(super) struct Performance<'a> {
    pub(super) motion: &'a FigureMotion,
    pub(super) root: Root,
}

impl Performance<'_> {
    /// Poses of all joints so many frames before the first: they move on as they do in the first step.
    pub(super) fn joint_poses_before(&self, frames: u32) -> [Transform; BODY_COUNT] {
        let [first, second] = [self.joint_poses(0), self.joint_poses(1)];
        std::array::from_fn(|joint| before_the_first(&first[joint], &second[joint], frames))
    }

    /// Poses of all joints in frame `frame` (the last one, beyond the end), each in its parent's frame.
    pub(super) fn joint_poses(&self, frame: usize) -> [Transform; BODY_COUNT] {
        let mut poses = self.motion.joint_poses(frame);
        if self.root == Root::Fixed {
            poses[0] = self.motion.joint_poses(0)[0];
        }
        poses
    }

    /// World poses of the bodies in one frame, on a figure with the given offsets.
    pub(super) fn world_poses(
        &self,
        offset_m: &[DVec3; BODY_COUNT],
        frame: usize,
    ) -> [Pose; BODY_COUNT] {
        let motion = self.motion;
        let rotation = &motion.rotation[frame];
        let root_frame = match self.root {
            Root::Driven => frame,
            Root::Fixed => 0,
        };
        let root = Pose {
            rotation: motion.rotation[root_frame][0],
            position_m: motion.root_position_m[root_frame],
        };
        let mut poses = [root; BODY_COUNT];
        for (body, place) in BODIES.iter().enumerate() {
            if let Some(parent) = place.parent {
                poses[body] = poses[parent].child(offset_m[body], rotation[body]);
            }
        }
        poses
    }

    /// The figure at the first frame, with the velocity of its first step.
    pub(super) fn start(&self, offset_m: &[DVec3; BODY_COUNT]) -> [MovingPose; BODY_COUNT] {
        let [now, next] = [0, 1].map(|frame| self.world_poses(offset_m, frame));
        std::array::from_fn(|body| moving(now[body], [now[body], next[body]], self.motion.dt_s))
    }
}

/// A body at a pose with the velocity that leads from one pose to another.
fn moving(pose: Pose, [from, to]: [Pose; 2], dt_s: f64) -> MovingPose {
    MovingPose {
        pose,
        angular_rad_s: rotation_vector(to.rotation * from.rotation.conjugate()) / dt_s,
        linear_m_s: (to.position_m - from.position_m) / dt_s,
    }
}

/// Poses one step before the start, from which backward differences give the start's velocity.
pub(super) fn one_step_before(start: &[MovingPose; BODY_COUNT], dt_s: f64) -> [Pose; BODY_COUNT] {
    start.map(|start| Pose {
        rotation: DQuat::from_scaled_axis(start.angular_rad_s * -dt_s) * start.pose.rotation,
        position_m: start.pose.position_m - start.linear_m_s * dt_s,
    })
}

/// Axis times angle, by the shorter way.
fn rotation_vector(q: DQuat) -> DVec3 {
    if q.w < 0.0 { (-q).to_scaled_axis() } else { q.to_scaled_axis() }
}
