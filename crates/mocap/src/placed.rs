//! Computes the rotations of joints for files that contain only positions.
//!
//! Some exporters write the position of every joint, and rotations that never change. The bones then point elsewhere
//! than the rotations say, and a figure that follows the rotations would not move.

use glam::{DQuat, DVec3};

use crate::recording::Frames;
use crate::skeleton::{JointSample, Skeleton, forward_kinematics};

/// Largest change of a rotation that still counts as constant, as 1 minus the cosine of half the angle. Rounding in a
/// text causes such changes.
const TURNS: f64 = 1e-9;
/// Smallest change of a bone's direction, rad, that counts as motion.
const MOVES_RAD: f64 = 0.02;
/// Shortest bone that has a direction, as a share of the longest bone.
const SHORT: f64 = 1e-6;
/// Number of corrections of a rotation that several bones determine: a few suffice to converge.
const CORRECTIONS: usize = 20;

/// Computes the rotations of a motion in which no joint except the root turns although joints move. Returns a note; or
/// `None` for any other motion, which is unchanged.
///
/// A joint gets the smallest rotation relative to its parent that points its bones at the joints beyond. Positions in
/// the world do not change. Rotations about the bones' own axes remain unknown. A frame in which a joint has no sample
/// becomes a gap of all joints.
pub(crate) fn turn(skeleton: &mut Skeleton, frames: &mut Frames) -> Option<String> {
    let first: Vec<JointSample> =
        frames.iter().find_map(|frame| frame.iter().copied().collect::<Option<_>>())?;
    let longest = first.iter().skip(1).map(|sample| sample.position_m.length()).fold(0.0, f64::max);
    let short = SHORT * longest;
    let has_turned = |(joint, sample): (usize, &Option<JointSample>)| {
        sample.is_some_and(|sample| {
            joint > 0 && sample.rotation.dot(first[joint].rotation).abs() < 1.0 - TURNS
        })
    };
    if frames.iter().any(|frame| frame.iter().enumerate().any(has_turned)) {
        return None;
    }
    let has_moved = |joint: &usize| {
        frames.iter().filter_map(|frame| frame[*joint]).any(|sample| {
            let [a, b] = [sample.position_m, first[*joint].position_m];
            a.length() > short && b.length() > short && angle(a, b) > MOVES_RAD
        })
    };
    let moved = (1..skeleton.joints.len()).filter(has_moved).count();
    if moved == 0 {
        return None;
    }
    // Without an offset, the bone of the first frame is the bone at rest.
    for (joint, sample) in skeleton.joints.iter_mut().zip(&first).skip(1) {
        if joint.offset_m.length() <= short {
            joint.offset_m = sample.position_m;
        }
    }
    let bones = Bones::of(skeleton, short);
    for frame in frames {
        // A joint without a sample leaves those before and beyond it without a direction.
        let whole: Option<Vec<_>> = frame.iter().copied().collect();
        let turned = whole.map(|local| bones.turned(&local).into_iter().map(Some).collect());
        *frame = turned.unwrap_or_else(|| vec![None; frame.len()]);
    }
    Some(format!(
        "no joint turns, and {moved} move by position channels: rotations are computed from positions; turns about a \
         bone are unknown"
    ))
}

/// Bones of a skeleton that have a direction.
struct Bones<'a> {
    skeleton: &'a Skeleton,
    /// Children of each joint, the one with the longest bone first.
    children: Vec<Vec<usize>>,
    short: f64,
}

impl<'a> Bones<'a> {
    fn of(skeleton: &'a Skeleton, short: f64) -> Self {
        let mut children = vec![Vec::new(); skeleton.joints.len()];
        let length = |joint: &usize| skeleton.joints[*joint].offset_m.length();
        for (joint, described) in skeleton.joints.iter().enumerate() {
            if let Some(parent) = described.parent.filter(|_| length(&joint) > short) {
                children[parent].push(joint);
            }
        }
        for children in &mut children {
            children.sort_by(|a: &usize, b| length(b).total_cmp(&length(a)));
        }
        Self { skeleton, children, short }
    }

    /// Returns the samples with rotations that point each bone at the joint at its end.
    fn turned(&self, local: &[JointSample]) -> Vec<JointSample> {
        let world = forward_kinematics(self.skeleton, local);
        // Turn of each joint in the world, on top of the rotation that the file gives.
        let mut turns: Vec<DQuat> = Vec::with_capacity(world.len());
        for (joint, described) in self.skeleton.joints.iter().enumerate() {
            let of_parent = described.parent.map_or(DQuat::IDENTITY, |parent| turns[parent]);
            let pairs: Vec<[DVec3; 2]> = self.children[joint]
                .iter()
                .filter_map(|child| {
                    let rest = world[joint].rotation * self.skeleton.joints[*child].offset_m;
                    let way = world[*child].position_m - world[joint].position_m;
                    (way.length() > self.short).then(|| [rest.normalize(), way.normalize()])
                })
                .collect();
            turns.push(turn_onto(&pairs, of_parent));
        }
        let rotation = |joint: usize| (turns[joint] * world[joint].rotation).normalize();
        let sample = |(joint, described): (usize, &crate::SkeletonJoint)| match described.parent {
            None => JointSample { rotation: rotation(joint), ..world[joint] },
            Some(parent) => {
                let back = rotation(parent).conjugate();
                JointSample {
                    rotation: (back * rotation(joint)).normalize(),
                    position_m: back * (world[joint].position_m - world[parent].position_m),
                }
            }
        };
        self.skeleton.joints.iter().enumerate().map(sample).collect()
    }
}

/// Returns the rotation that best turns the first direction of each pair onto the second; of several such rotations,
/// the one nearest to `near`.
fn turn_onto(pairs: &[[DVec3; 2]], near: DQuat) -> DQuat {
    let Some([from, to]) = pairs.first() else { return near };
    let first = DQuat::from_rotation_arc(near * *from, *to) * near;
    // About the first bone, the others decide.
    let (mut sine, mut cosine) = (0.0, 0.0);
    for [from, to_other] in &pairs[1..] {
        let [a, b] = [first * *from, *to_other].map(|way| way - way.dot(*to) * *to);
        sine += a.cross(b).dot(*to);
        cosine += a.dot(b);
    }
    if libm::hypot(sine, cosine) < 1e-6 {
        return first;
    }
    let mut turn = DQuat::from_axis_angle(*to, libm::atan2(sine, cosine)) * first;
    for _ in 0..CORRECTIONS {
        let off: DVec3 = pairs.iter().map(|[from, to]| (turn * *from).cross(*to)).sum();
        turn = DQuat::from_scaled_axis(off / pairs.len() as f64) * turn;
    }
    turn.normalize()
}

fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::SkeletonJoint;

    /// A trunk with two limbs of three bones.
    fn skeleton() -> Skeleton {
        let joint = |parent: Option<usize>, offset: [f64; 3]| SkeletonJoint {
            name: String::new(),
            parent,
            offset_m: offset.into(),
            end_sites_m: Vec::new(),
        };
        Skeleton {
            joints: vec![
                joint(None, [0.0; 3]),
                joint(Some(0), [0.0, 30.0, 0.0]),
                joint(Some(1), [10.0, 2.0, 0.0]),
                joint(Some(2), [20.0, 0.0, 0.0]),
                joint(Some(3), [18.0, 0.0, 0.0]),
                joint(Some(1), [-10.0, 2.0, 0.0]),
                joint(Some(5), [-20.0, 0.0, 0.0]),
                joint(Some(1), [0.0, 12.0, 1.0]),
            ],
        }
    }

    fn rotation(parts: [f64; 3]) -> DQuat {
        DQuat::from_scaled_axis(DVec3::from_array(parts))
    }

    proptest! {
        /// From the positions of a motion that rotates, the computed rotations give the directions of its bones again,
        /// and the whole rotation of a joint with several bones.
        #[test]
        fn rotations_come_back_from_positions(
            turns in prop::collection::vec([-0.8..0.8, -0.8..0.8, -0.8..0.8], 16),
        ) {
            let mut skeleton = skeleton();
            let turned = |frame: usize| -> Vec<JointSample> {
                let joints = skeleton.joints.iter().enumerate();
                let sample = |(joint, at): (usize, &SkeletonJoint)| JointSample {
                    rotation: rotation(turns[8 * frame + joint]),
                    position_m: at.offset_m,
                };
                forward_kinematics(&skeleton, &joints.map(sample).collect::<Vec<_>>())
            };
            let worlds = [turned(0), turned(1)];
            let moved = |world: &Vec<JointSample>| -> Vec<Option<JointSample>> {
                let joints = skeleton.joints.iter().enumerate();
                let sample = |(joint, at): (usize, &SkeletonJoint)| {
                    let from = at.parent.map_or(DVec3::ZERO, |parent| world[parent].position_m);
                    let position_m = world[joint].position_m - from;
                    Some(JointSample { rotation: DQuat::IDENTITY, position_m })
                };
                joints.map(sample).collect()
            };
            let mut frames: Frames = worlds.iter().map(moved).collect();
            prop_assert!(turn(&mut skeleton, &mut frames).is_some());
            for (frame, world) in frames.iter().zip(&worlds) {
                let local: Vec<JointSample> = frame.iter().copied().map(Option::unwrap).collect();
                let found = forward_kinematics(&skeleton, &local);
                for (joint, at) in skeleton.joints.iter().enumerate() {
                    prop_assert!(found[joint].position_m.distance(world[joint].position_m) < 1e-9);
                    // The samples have the offsets: each bone is where its parent's rotation puts it.
                    prop_assert!(joint == 0 || local[joint].position_m.distance(at.offset_m) < 1e-6);
                }
                prop_assert!(found[1].rotation.dot(world[1].rotation).abs() > 1.0 - 1e-9);
            }
        }
    }

    #[test]
    fn a_motion_that_turns_or_rests_stays() {
        let mut skeleton = skeleton();
        let rest = |turn: DQuat, lift: f64| -> Vec<Option<JointSample>> {
            let sample = |at: &SkeletonJoint| {
                Some(JointSample { rotation: turn, position_m: at.offset_m + DVec3::Y * lift })
            };
            skeleton.joints.iter().map(sample).collect()
        };
        let turned = vec![rest(DQuat::IDENTITY, 0.0), rest(rotation([0.1, 0.0, 0.0]), 5.0)];
        let still = vec![rest(DQuat::IDENTITY, 0.0), rest(DQuat::IDENTITY, 0.0)];
        for frames in [turned, still] {
            let mut after = frames.clone();
            assert_eq!(turn(&mut skeleton, &mut after), None);
            assert_eq!(after, frames);
        }
    }
}
