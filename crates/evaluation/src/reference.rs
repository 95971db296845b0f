//! Converts the motion for the controller, the plant and the measurement of errors.

use glam::{DQuat, DVec3};
use sinew_core::Transform;
use sinew_core::tracker::{Frame, FrameSource, extrapolate_before_start};
use sinew_figure::plant::{MovingPose, Pose};
use sinew_rig::mechanism::{JointModel, Link};

use super::motion::EvaluatedMotion;
use super::setup::Setup;

/// A motion that the bodies of a rig perform.
#[derive(Clone, Copy)]
pub(super) struct Performance<'a> {
    pub(super) motion: &'a dyn EvaluatedMotion,
    pub(super) setup: &'a Setup,
    pub(super) links: &'a [Link],
}

impl Performance<'_> {
    /// Writes the world poses of the bodies in one frame to `out`, in the motion's own dimensions.
    pub(super) fn desired(&self, frame: usize, out: &mut Vec<Pose>) {
        self.world_poses(frame, |_, pose| pose.position_m, out);
    }

    /// Returns the world poses of the bodies in one frame, in the rig's dimensions.
    fn on_rig(&self, frame: usize) -> Vec<Pose> {
        let mut poses = Vec::new();
        let position_m = |link: &Link, pose: &Pose| match link.joint {
            JointModel::Prismatic(_) | JointModel::Free => pose.position_m,
            _ => link.position_m,
        };
        self.world_poses(frame, position_m, &mut poses);
        poses
    }

    fn world_poses(
        &self,
        frame: usize,
        position_m: impl Fn(&Link, &Pose) -> DVec3,
        out: &mut Vec<Pose>,
    ) {
        self.motion.joint_poses(self.setup, frame, out);
        for (body, link) in self.links.iter().enumerate() {
            if let Some(parent) = link.parent {
                let pose = out[body];
                out[body] = out[parent].child(position_m(link, &pose), pose.rotation);
            }
        }
    }

    /// Returns the rig's state at the first frame, with the velocity of its first step.
    pub(super) fn start(&self) -> Vec<MovingPose> {
        let [now, next] = [0, 1].map(|frame| self.on_rig(frame));
        let steps = now.iter().zip(&next);
        steps.map(|(now, next)| moving(now, next, self.motion.dt_s())).collect()
    }
}

/// Frames of a performance, as the tracker requests them.
pub(super) struct Frames<'a> {
    motion: &'a dyn EvaluatedMotion,
    setup: &'a Setup,
    poses: Vec<Pose>,
    joints: Vec<Transform>,
}

impl<'a> Frames<'a> {
    pub(super) fn new(motion: &'a dyn EvaluatedMotion, setup: &'a Setup) -> Self {
        Self { motion, setup, poses: Vec::new(), joints: Vec::new() }
    }

    /// Reads a frame.
    pub(super) fn read(&mut self, frame: usize) {
        self.motion.joint_poses(self.setup, frame, &mut self.poses);
        let single =
            |pose: &Pose| Transform::new(pose.rotation.as_quat(), pose.position_m.as_vec3());
        self.joints.clear();
        self.joints.extend(self.poses.iter().map(single));
    }

    /// Returns the poses of the joints in the frame that was read last.
    pub(super) fn joints(&self) -> &[Transform] {
        &self.joints
    }
}

impl FrameSource for Frames<'_> {
    fn frame(&mut self, index: i32) -> Frame<'_> {
        if let Ok(index) = usize::try_from(index) {
            self.read(index);
        } else {
            // Before the start, the motion is extrapolated from its first step.
            self.read(1);
            let second = self.joints.clone();
            self.read(0);
            for (joint, second) in self.joints.iter_mut().zip(&second) {
                *joint = extrapolate_before_start(joint, second, index.unsigned_abs());
            }
        }
        Frame::Poses(&self.joints)
    }
}

/// Returns a body at a pose, with the velocity that leads from there to the next pose.
fn moving(pose: &Pose, next: &Pose, dt_s: f64) -> MovingPose {
    MovingPose {
        pose: *pose,
        angular_rad_s: rotation_vector(next.rotation * pose.rotation.conjugate()) / dt_s,
        linear_m_s: (next.position_m - pose.position_m) / dt_s,
    }
}

/// Returns the poses one step before the start, for which backward differences give the start's velocity.
pub(super) fn one_step_before(start: &[MovingPose], dt_s: f64) -> Vec<Pose> {
    let before = |start: &MovingPose| Pose {
        rotation: DQuat::from_scaled_axis(start.angular_rad_s * -dt_s) * start.pose.rotation,
        position_m: start.pose.position_m - start.linear_m_s * dt_s,
    };
    start.iter().map(before).collect()
}

/// Returns axis times angle of a rotation, with an angle of at most π.
pub(super) fn rotation_vector(q: DQuat) -> DVec3 {
    if q.w < 0.0 { (-q).to_scaled_axis() } else { q.to_scaled_axis() }
}
