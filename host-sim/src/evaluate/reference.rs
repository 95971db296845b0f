//! The clip as the controller, the plant and the measurement of errors take it.

use glam::{DQuat, DVec3};

use crate::figure::{BODIES, BODY_COUNT};
use crate::mocap::FigureMotion;
use crate::plant::{MovingPose, Pose};

/// World poses of the bodies in one frame of the clip, on a figure with the given offsets.
pub(super) fn world_poses(
    motion: &FigureMotion,
    offset_m: &[DVec3; BODY_COUNT],
    frame: usize,
) -> [Pose; BODY_COUNT] {
    let rotation = &motion.rotation[frame];
    let root = Pose { rotation: rotation[0], position_m: motion.root_position_m[frame] };
    let mut poses = [root; BODY_COUNT];
    for (body, place) in BODIES.iter().enumerate() {
        if let Some(parent) = place.parent {
            poses[body] = poses[parent].child(offset_m[body], rotation[body]);
        }
    }
    poses
}

/// The figure at the clip's first frame, with the velocity of its first step.
pub(super) fn moving_poses(
    motion: &FigureMotion,
    offset_m: &[DVec3; BODY_COUNT],
) -> [MovingPose; BODY_COUNT] {
    let [now, next] = [0, 1].map(|frame| world_poses(motion, offset_m, frame));
    std::array::from_fn(|body| {
        let (now, next) = (now[body], next[body]);
        MovingPose {
            pose: now,
            angular_rad_s: rotation_vector(next.rotation * now.rotation.conjugate()) / motion.dt_s,
            linear_m_s: (next.position_m - now.position_m) / motion.dt_s,
        }
    })
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
