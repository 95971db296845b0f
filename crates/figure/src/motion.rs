//! The motion of the 18-body figure, into which every clip is converted.

use glam::{DQuat, DVec3};
use sinew_core::Transform;
use sinew_core::trajectory::interpolate_smoothly;

use super::BODIES;

/// A clip mapped to the figure, evenly sampled and filtered.
///
/// World frame: right-handed, y up, metres. Body frame `i` has its origin at joint `i`.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureMotion {
    /// Name of the clip.
    pub name: String,
    /// Time from one frame to the next, in seconds.
    pub dt_s: f64,
    /// Position of joint `i` in the frame of body `i`'s parent; zero for the root.
    pub offset_m: Vec<DVec3>,
    /// End of the segment in the frame of body `i`: the next joint along it, or the end of the head, hand or foot.
    /// It gives the body model the direction of the segment. The pelvis ends at the next joint of the trunk; in
    /// skeletons where the abdomen begins at the pelvis' own origin, both end at the thorax.
    pub segment_end_m: Vec<DVec3>,
    /// World position of the pelvis in each frame.
    pub root_position_m: Vec<DVec3>,
    /// Rotation from body `i` to its parent (the pelvis: to the world) in each frame, unit.
    pub rotation: Vec<Vec<DQuat>>,
}

impl FigureMotion {
    /// Returns the world position of every joint in frame `frame`, in metres.
    pub fn world_positions_m(&self, frame: usize) -> Vec<DVec3> {
        let mut position_m = vec![self.root_position_m[frame]; BODIES.len()];
        let mut rotation = self.rotation[frame].clone();
        for (i, body) in BODIES.iter().enumerate() {
            if let Some(parent) = body.parent {
                position_m[i] = position_m[parent] + rotation[parent] * self.offset_m[i];
                rotation[i] = rotation[parent] * rotation[i];
            }
        }
        position_m
    }

    /// Returns the motion with `factor` times the frames, by the core's smooth interpolation. Firmware
    /// interpolates in the same way if a show has fewer frames than ticks.
    #[must_use]
    pub fn interpolated(&self, factor: usize) -> Self {
        let last = self.rotation.len() - 1;
        let frames: Vec<_> = (0..=last).map(|frame| self.joint_poses(frame)).collect();
        let (mut root_position_m, mut rotation) = (Vec::new(), Vec::new());
        for step in 0..=last * factor {
            let (from, fraction) = (step / factor, (step % factor) as f32 / factor as f32);
            let window = [from.saturating_sub(1), from, from + 1, from + 2];
            let window = window.map(|frame| &frames[frame.min(last)]);
            let joints: Vec<Transform> = (0..BODIES.len())
                .map(|joint| interpolate_smoothly(window.map(|frame| &frame[joint]), fraction))
                .collect();
            root_position_m.push(joints[0].translation_m.as_dvec3());
            rotation
                .push(joints.iter().map(|joint| joint.rotation.as_dquat().normalize()).collect());
        }
        Self {
            name: self.name.clone(),
            dt_s: self.dt_s / factor as f64,
            root_position_m,
            rotation,
            offset_m: self.offset_m.clone(),
            segment_end_m: self.segment_end_m.clone(),
        }
    }

    /// Returns the poses of all joints in frame `frame`, each in its parent's frame, in the core's type. After the
    /// end the last frame is used.
    pub fn joint_poses(&self, frame: usize) -> Vec<Transform> {
        self.joints(frame)
            .map(|(rotation, position_m)| Transform::new(rotation.as_quat(), position_m.as_vec3()))
            .collect()
    }

    /// Returns the rotations and positions (m) of all joints in frame `frame`, each in its parent's frame; the
    /// root's are in the world. After the end the last frame is used.
    pub fn joints(&self, frame: usize) -> impl Iterator<Item = (DQuat, DVec3)> + '_ {
        let frame = frame.min(self.rotation.len() - 1);
        let root_m = self.root_position_m[frame];
        let positions_m = std::iter::once(root_m).chain(self.offset_m.iter().skip(1).copied());
        self.rotation[frame].iter().copied().zip(positions_m)
    }
}
