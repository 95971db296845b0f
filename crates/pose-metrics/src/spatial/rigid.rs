//! Removes the joints that do not move: bodies that are rigidly connected in all clips become one body.

use glam::{DQuat, DVec3};
use sinew_mocap::{Skeleton, SkeletonJoint};

/// Difference below which two rotations are equal: readers' rounding of degrees with two digits is smaller.
const STILL: f64 = 1e-7;

/// The joints that move, and the conversion of poses of all joints to poses of these. If a moving joint has no moving
/// descendants, its farthest descendant is kept too: it is the end of the moving bone.
#[derive(Debug, Clone, PartialEq)]
pub struct Rigid {
    /// Skeleton of the kept joints, parents first.
    pub skeleton: Skeleton,
    /// Indices of the kept joints, and the constant rotation of the joints between each and its kept parent.
    kept: Vec<(usize, DQuat)>,
}

impl Rigid {
    /// Removes the joints whose local rotation is equal in all `poses`, which contain a rotation for each joint. The
    /// root, the joint called `always` and the ends of moving bones are kept. If fewer than two joints remained without
    /// these ends, all are kept.
    pub fn new<'p>(
        skeleton: &Skeleton,
        poses: impl IntoIterator<Item = &'p Vec<DQuat>>,
        always: Option<&str>,
    ) -> Self {
        let mut poses = poses.into_iter();
        let count = skeleton.joints.len();
        let still = poses.next().cloned().unwrap_or_else(|| vec![DQuat::IDENTITY; count]);
        let mut keeps: Vec<bool> = skeleton
            .joints
            .iter()
            .map(|joint| joint.parent.is_none() || Some(joint.name.as_str()) == always)
            .collect();
        for pose in poses {
            for ((keeps, rotation), first) in keeps.iter_mut().zip(pose).zip(&still) {
                *keeps = *keeps || 1.0 - rotation.dot(*first).abs() > STILL;
            }
        }
        // A single pose does not show which joints move.
        if keeps.iter().filter(|keeps| **keeps).count() < 2 {
            keeps.fill(true);
        }
        keep_ends(skeleton, &still, &mut keeps);
        Self::of(skeleton, &still, &keeps)
    }

    fn of(skeleton: &Skeleton, still: &[DQuat], keeps: &[bool]) -> Self {
        let mut rigid = Self { skeleton: Skeleton { joints: Vec::new() }, kept: Vec::new() };
        // For each joint: its nearest kept ancestor or itself, and its pose relative to that.
        let mut places: Vec<(usize, DQuat, DVec3)> = Vec::with_capacity(keeps.len());
        for (index, joint) in skeleton.joints.iter().enumerate() {
            let on = joint.parent.map(|parent| places[parent]);
            let (turn, offset_m) = on.map_or((DQuat::IDENTITY, joint.offset_m), |on| {
                (on.1, on.2 + on.1 * joint.offset_m)
            });
            if keeps[index] {
                places.push((rigid.kept.len(), DQuat::IDENTITY, DVec3::ZERO));
                rigid.kept.push((index, turn));
                rigid.skeleton.joints.push(SkeletonJoint {
                    name: joint.name.clone(),
                    parent: on.map(|on| on.0),
                    offset_m,
                    end_sites_m: joint.end_sites_m.clone(),
                });
            } else {
                // The root is kept; therefore a parent exists.
                let parent = on.map_or(0, |on| on.0);
                places.push((parent, (turn * still[index]).normalize(), offset_m));
            }
        }
        rigid
    }

    /// Returns the pose of the kept joints, from a pose of all joints.
    pub fn pose(&self, all: &[DQuat]) -> Vec<DQuat> {
        let place = |(joint, turn): &(usize, DQuat)| turned(*turn, all[*joint]);
        self.kept.iter().map(place).collect()
    }

    /// Returns, for each kept joint, its index among all joints and its local rotation, from a pose of the kept
    /// joints.
    pub fn joints<'s>(&'s self, pose: &'s [DQuat]) -> impl Iterator<Item = (usize, DQuat)> + 's {
        let local = |((joint, turn), rotation): (&(usize, DQuat), &DQuat)| {
            (*joint, turned(turn.inverse(), *rotation))
        };
        self.kept.iter().zip(pose).map(local)
    }
}

/// Returns a rotation preceded by `turn`. If `turn` is the identity, the result has exactly the same bits.
fn turned(turn: DQuat, rotation: DQuat) -> DQuat {
    if turn == DQuat::IDENTITY { rotation } else { (turn * rotation).normalize() }
}

/// Keeps, for each moving joint without moving descendants, its farthest descendant.
fn keep_ends(skeleton: &Skeleton, still: &[DQuat], keeps: &mut [bool]) {
    let mut carries = keeps.to_vec();
    for (index, joint) in skeleton.joints.iter().enumerate().rev() {
        if let Some(parent) = joint.parent {
            carries[parent] |= carries[index];
        }
    }
    let is_bare = |joint: usize| {
        let moves_below = skeleton
            .joints
            .iter()
            .enumerate()
            .any(|(child, of)| of.parent == Some(joint) && carries[child]);
        keeps[joint] && !moves_below
    };
    // For each joint: its nearest ancestor (or itself) that moves and has no moving descendants, and its place on
    // that.
    let mut places: Vec<Option<(usize, DQuat, DVec3)>> = Vec::with_capacity(keeps.len());
    let mut farthest: Vec<Option<(f64, usize)>> = vec![None; keeps.len()];
    for (index, joint) in skeleton.joints.iter().enumerate() {
        if keeps[index] {
            places.push(is_bare(index).then_some((index, DQuat::IDENTITY, DVec3::ZERO)));
            continue;
        }
        let place = joint.parent.and_then(|parent| places[parent]).map(|(on, turn, at_m)| {
            (on, (turn * still[index]).normalize(), at_m + turn * joint.offset_m)
        });
        if let Some((on, _, at_m)) = place {
            let is_farther = farthest[on].is_none_or(|(most, _)| at_m.length() > most);
            if at_m != DVec3::ZERO && is_farther {
                farthest[on] = Some((at_m.length(), index));
            }
        }
        places.push(place);
    }
    for (_, end) in farthest.into_iter().flatten() {
        keeps[end] = true;
    }
}

#[cfg(test)]
mod tests {
    use glam::EulerRot;
    use sinew_mocap::{JointSample, forward_kinematics};

    use super::*;
    use sinew_figure::builtin;

    fn world_m(skeleton: &Skeleton, pose: &[DQuat]) -> Vec<DVec3> {
        let local: Vec<JointSample> = skeleton
            .joints
            .iter()
            .zip(pose)
            .map(|(joint, rotation)| JointSample {
                rotation: *rotation,
                position_m: joint.offset_m,
            })
            .collect();
        forward_kinematics(skeleton, &local).iter().map(|joint| joint.position_m).collect()
    }

    #[test]
    fn what_stays_is_where_it_was() {
        let skeleton = builtin::clips()[0].skeleton.clone();
        let names = ["pelvis", "thorax", "forearm_l", "thigh_r"];
        let moves: Vec<usize> = names.iter().map(|name| skeleton.find(name).unwrap()).collect();
        let turn = |j: f64| DQuat::from_euler(EulerRot::XYZ, 0.3 * j, 1.0 - 0.2 * j, 0.1 * j * j);
        let pose = |seed: f64| -> Vec<DQuat> {
            let of = |joint: usize| if moves.contains(&joint) { seed } else { 0.0 };
            (0..skeleton.joints.len()).map(|joint| turn(joint as f64 + of(joint))).collect()
        };
        let poses = [pose(0.0), pose(0.5), pose(2.0)];
        let rigid = Rigid::new(&skeleton, &poses, Some("head"));
        let kept: Vec<&str> =
            rigid.skeleton.joints.iter().map(|joint| joint.name.as_str()).collect();
        // The ends of the forearm and of the thigh are kept; the thorax has an arm that moves.
        assert_eq!(kept, ["pelvis", "thorax", "head", "forearm_l", "hand_l", "thigh_r", "foot_r"]);
        for pose in &poses {
            let all_m = world_m(&skeleton, pose);
            let some_m = world_m(&rigid.skeleton, &rigid.pose(pose));
            for (name, at_m) in kept.iter().zip(some_m) {
                let off_m = at_m.distance(all_m[skeleton.find(name).unwrap()]);
                assert!(off_m < 1e-12, "{name}: {off_m}");
            }
        }
    }

    #[test]
    fn of_one_pose_all_joints_stay() {
        let skeleton = builtin::clips()[0].skeleton.clone();
        let pose = vec![DQuat::from_rotation_x(0.4); skeleton.joints.len()];
        let rigid = Rigid::new(&skeleton, [&pose], None);
        assert_eq!(rigid.skeleton.joints.len(), skeleton.joints.len());
        assert_eq!(rigid.pose(&pose), pose);
    }
}
