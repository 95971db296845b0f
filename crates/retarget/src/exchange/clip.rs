//! Converts a rig's motion to a clip of a skeleton.

use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint};
use sinew_rig::Mechanism;

use crate::feasibility::RigMotion;

/// Converts the motion of the rig's bodies to a clip with a joint for each body. In the pose in which all coordinates
/// are zero, the joints have world axes, as in animators' files. The ends of a bone are the positions of the bodies
/// that were merged into it; without merged bodies and without children, the end is the point at twice the vector to
/// the centre of mass.
pub fn clip(name: &str, mechanism: &Mechanism, motion: &RigMotion) -> Clip {
    let zero: Vec<f64> = mechanism.bodies.iter().flat_map(|link| link.joint.zero()).collect();
    let rest = mechanism.poses(&zero);
    let mut has_child = vec![false; mechanism.bodies.len()];
    for parent in mechanism.bodies.iter().filter_map(|link| link.parent) {
        has_child[parent] = true;
    }
    let joints = mechanism
        .bodies
        .iter()
        .enumerate()
        .map(|(body, link)| {
            let position_m = rest[body].position_m;
            let from_parent =
                link.parent.map_or(position_m, |parent| position_m - rest[parent].position_m);
            let mut ends: Vec<DVec3> = link.merged.iter().map(|merged| merged.position_m).collect();
            if ends.is_empty() && !has_child[body] {
                ends.push(2.0 * link.center_of_mass_m);
            }
            ends.retain(|end| end.length() > 1e-9);
            SkeletonJoint {
                name: link.joint_name.clone(),
                parent: link.parent,
                offset_m: if body == 0 { DVec3::ZERO } else { from_parent },
                end_sites_m: ends.into_iter().map(|end| rest[body].rotation * end).collect(),
            }
        })
        .collect();
    // Rotation of a body from its rest in the world, relative to its parent's.
    let frame = |q: &Vec<f64>| {
        let poses = mechanism.poses(q);
        let turned = |body: usize| poses[body].rotation * rest[body].rotation.conjugate();
        mechanism
            .bodies
            .iter()
            .enumerate()
            .map(|(body, link)| {
                let (rotation, position_m) = match link.parent {
                    None => (turned(body), poses[body].position_m),
                    Some(parent) => {
                        let back: DQuat = turned(parent).conjugate();
                        let arm_m = poses[body].position_m - poses[parent].position_m;
                        (back * turned(body), back * arm_m)
                    }
                };
                JointSample { rotation: rotation.normalize(), position_m }
            })
            .collect()
    };
    Clip {
        name: name.to_owned(),
        skeleton: Skeleton { joints },
        frame_time_s: motion.dt_s,
        frames: motion.rows.iter().map(frame).collect(),
    }
}
