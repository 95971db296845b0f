//! Errors of reconstructed poses.

use glam::DVec3;
use serde::Serialize;
use sinew_mocap::Skeleton;

use super::anatomy::Group;
use super::data::forward_kinematics;
use crate::recordings::Pose;

/// Mean errors of every joint over many poses, with the root at its true place.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Errors {
    /// Distances of the joints' positions, in centimetres; `None` if a joint always coincides with the root.
    pub position_cm: Vec<Option<f64>>,
    /// Angles between rotations relative to the parents, in degrees.
    pub local_deg: Vec<f64>,
    /// Angles between rotations in the world, in degrees.
    pub global_deg: Vec<f64>,
}

/// Means over joints.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Means {
    /// Mean distance of positions, in centimetres; `None` if none of the joints can move.
    pub position_cm: Option<f64>,
    /// Mean angle between original and reconstructed rotations, relative to the parents, in degrees.
    pub local_deg: f64,
    /// Mean angle between original and reconstructed rotations, in the world, in degrees.
    pub global_deg: f64,
}

impl Errors {
    /// Compares poses one by one.
    pub(super) fn new(skeleton: &Skeleton, originals: &[Pose], reconstructed: &[Pose]) -> Self {
        let joints = skeleton.joints.len();
        let mut sums = vec![[0.0; 3]; joints];
        for (original, reconstructed) in originals.iter().zip(reconstructed) {
            let worlds = [original, reconstructed].map(|pose| forward_kinematics(skeleton, pose));
            for (joint, sums) in sums.iter_mut().enumerate() {
                let [from, to] = [worlds[0][joint], worlds[1][joint]];
                sums[0] += 100.0 * from.position_m.distance(to.position_m);
                sums[1] += original[joint].angle_between(reconstructed[joint]).to_degrees();
                sums[2] += from.rotation.angle_between(to.rotation).to_degrees();
            }
        }
        let mean = |joint: usize, what: usize| sums[joint][what] / originals.len() as f64;
        let moves = moving(skeleton);
        Self {
            position_cm: (0..joints).map(|j| moves[j].then(|| mean(j, 0))).collect(),
            local_deg: (0..joints).map(|joint| mean(joint, 1)).collect(),
            global_deg: (0..joints).map(|joint| mean(joint, 2)).collect(),
        }
    }

    /// Returns the means over all joints, or over those of a group.
    pub fn means(&self, groups: &[Group], group: Option<Group>) -> Means {
        let joints = || {
            let is_in = |joint: &usize| group.is_none_or(|group| groups[*joint] == group);
            (0..groups.len()).filter(is_in)
        };
        let positions: Vec<f64> = joints().filter_map(|joint| self.position_cm[joint]).collect();
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        Means {
            position_cm: (!positions.is_empty()).then(|| mean(positions)),
            local_deg: mean(joints().map(|joint| self.local_deg[joint]).collect()),
            global_deg: mean(joints().map(|joint| self.global_deg[joint]).collect()),
        }
    }
}

/// Returns the mean distance of a pose's joints from those of the original, in centimetres, over the joints that can
/// move relative to the root.
pub fn distance_cm(skeleton: &Skeleton, original: &Pose, pose: &Pose) -> f64 {
    let errors = Errors::new(skeleton, std::slice::from_ref(original), std::slice::from_ref(pose));
    let distances: Vec<f64> = errors.position_cm.into_iter().flatten().collect();
    distances.iter().sum::<f64>() / distances.len().max(1) as f64
}

/// Returns which joints can be at another place than the root.
fn moving(skeleton: &Skeleton) -> Vec<bool> {
    let mut moves: Vec<bool> = Vec::new();
    for joint in &skeleton.joints {
        let lever = |parent: usize| moves[parent] || joint.offset_m != DVec3::ZERO;
        moves.push(joint.parent.is_some_and(lever));
    }
    moves
}
