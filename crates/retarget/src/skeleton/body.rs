//! A skeleton with all that its matching looks at: names, tree, lengths, poses.

use glam::DVec3;
use sinew_mocap::{JointSample, Skeleton, forward_kinematics};

use super::name::{Kind, Name, read_all};

/// So many frames of a clip are looked at, evenly spread.
const FRAMES_MAX: usize = 48;
/// A bone shorter than this part of the skeleton has no direction: it only carries a joint.
const ZERO: f64 = 2e-3;
/// A clip in which some joint bends so much shows which do not.
const MOVES_RAD: f64 = 0.4;
/// Bones of one line: rest poses have kinks of a few degrees.
const STRAIGHT_RAD: f64 = 0.2;

/// A skeleton, its names read, its bones measured.
pub(super) struct Body<'a> {
    pub skeleton: &'a Skeleton,
    pub names: Vec<Name>,
    pub children: Vec<Vec<usize>>,
    /// Length of the bone from the parent, in the skeleton's unit. Poses do not change it.
    pub lengths: Vec<f64>,
    /// Joints at which the bones before and after stay in one line, in a clip in which others bend: they only twist.
    pub stays_straight: Vec<bool>,
    /// Length of the longest way down from each joint, end sites included.
    pub below: Vec<f64>,
    /// Which joints are only the end of a bone.
    pub is_end: Vec<bool>,
    /// Positions of all joints: in the rest pose, then in frames of the clip.
    pub poses: Vec<Pose>,
}

/// Positions of all joints at one time.
pub(super) struct Pose {
    /// The frame; `None` is the rest pose.
    pub frame: Option<usize>,
    pub joints: Vec<JointSample>,
}

impl<'a> Body<'a> {
    pub(super) fn new(skeleton: &'a Skeleton, frames: &[Vec<JointSample>]) -> Self {
        let count = skeleton.joints.len();
        let mut children = vec![Vec::new(); count];
        for (joint, parent) in
            skeleton.joints.iter().enumerate().filter_map(|(j, s)| Some((j, s.parent?)))
        {
            children[parent].push(joint);
        }
        let picked = picked(frames.len());
        let lengths = lengths(skeleton, frames, &picked);
        let names =
            read_all(&skeleton.joints.iter().map(|joint| joint.name.as_str()).collect::<Vec<_>>());
        let mut below: Vec<f64> = (0..count).map(|joint| site_length(skeleton, joint)).collect();
        let mut is_end = vec![false; count];
        let turns = |joint: usize| {
            picked.iter().any(|frame| turns(frames[picked[0]][joint], frames[*frame][joint]))
        };
        let moving = (1..count).any(turns);
        for joint in (0..count).rev() {
            let name = &names[joint];
            // Nothing hangs on it, and it never turns: most writers give the end of a bone such a joint.
            let idle = name.is_silent() && below[joint] == 0.0 && moving && !turns(joint);
            is_end[joint] = (name.kind == Kind::End || idle)
                && children[joint].iter().all(|child: &usize| is_end[*child]);
            if let Some(parent) = skeleton.joints[joint].parent {
                below[parent] = below[parent].max(lengths[joint] + below[joint]);
            }
        }
        let rest = skeleton
            .rest_positions_m()
            .into_iter()
            .map(|position_m| JointSample { rotation: glam::DQuat::IDENTITY, position_m })
            .collect();
        let mut poses = vec![Pose { frame: None, joints: rest }];
        poses.extend(picked.iter().map(|frame| Pose {
            frame: Some(*frame),
            joints: forward_kinematics(skeleton, &frames[*frame]),
        }));
        let stays_straight = vec![false; count];
        let mut body =
            Self { skeleton, names, children, lengths, stays_straight, below, is_end, poses };
        let angles: Vec<_> = (0..count).map(|joint| body.angles(joint)).collect();
        if angles.iter().flatten().any(|(low, high)| high - low > MOVES_RAD) {
            let straight =
                |angles: &Option<(f64, f64)>| angles.is_some_and(|(_, high)| high < STRAIGHT_RAD);
            body.stays_straight = angles.iter().map(straight).collect();
        }
        body
    }

    pub(super) fn count(&self) -> usize {
        self.skeleton.joints.len()
    }

    pub(super) fn parent(&self, joint: usize) -> Option<usize> {
        self.skeleton.joints[joint].parent
    }

    pub(super) fn name(&self, joint: usize) -> &str {
        &self.skeleton.joints[joint].name
    }

    /// A joint, its parent, and so on to the root.
    pub(super) fn upwards(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(joint), |joint| self.parent(*joint))
    }

    /// Whether `joint` is `ancestor` or hangs on it.
    pub(super) fn hangs_on(&self, joint: usize, ancestor: usize) -> bool {
        // Parents come before children.
        self.upwards(joint).take_while(|other| *other >= ancestor).last() == Some(ancestor)
    }

    /// The lowest joint that both hang on.
    pub(super) fn common_ancestor(&self, mut a: usize, mut b: usize) -> usize {
        while a != b {
            // The later of the two is no ancestor of the other.
            let later = if a > b { &mut a } else { &mut b };
            *later = self.parent(*later).unwrap_or(0);
        }
        a
    }

    /// The joints below `ancestor` down to `joint`, which hangs on it; `ancestor` is left out.
    pub(super) fn way(&self, ancestor: usize, joint: usize) -> Vec<usize> {
        let mut way: Vec<usize> =
            self.upwards(joint).take_while(|other| *other != ancestor).collect();
        way.reverse();
        way
    }

    /// Sum of the bones from `ancestor` down to `joint`.
    pub(super) fn length(&self, ancestor: usize, joint: usize) -> f64 {
        self.upwards(joint)
            .take_while(|other| *other != ancestor)
            .map(|other| self.lengths[other])
            .sum()
    }

    /// Whether the joint sits on its parent.
    pub(super) fn is_at_parent(&self, joint: usize) -> bool {
        self.is_zero(self.lengths[joint])
    }

    /// Length to the joint's first end site; 0 without one.
    pub(super) fn site(&self, joint: usize) -> f64 {
        site_length(self.skeleton, joint)
    }

    pub(super) fn is_zero(&self, length: f64) -> bool {
        length <= ZERO * self.below[0]
    }

    /// The least and the largest angle between the bones before and after a joint in the clip, in radians.
    fn angles(&self, joint: usize) -> Option<(f64, f64)> {
        let parent = self.parent(joint)?;
        let child = *self.children[joint]
            .iter()
            .max_by(|a, b| self.lengths[**a].total_cmp(&self.lengths[**b]))?;
        if self.is_at_parent(joint) || self.is_at_parent(child) {
            return None;
        }
        let moving = self.poses.iter().filter(|pose| pose.frame.is_some());
        let angles = moving
            .map(|pose| angle(pose.at(joint) - pose.at(parent), pose.at(child) - pose.at(joint)));
        let (low, high) =
            angles.fold((f64::MAX, f64::MIN), |(low, high), a| (low.min(a), high.max(a)));
        (high >= low).then_some((low, high))
    }
}

impl Pose {
    pub(super) fn at(&self, joint: usize) -> DVec3 {
        self.joints[joint].position_m
    }

    pub(super) fn between(&self, a: usize, b: usize) -> DVec3 {
        0.5 * (self.at(a) + self.at(b))
    }
}

/// Angle between two directions, in radians; the same bits on every machine.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// Length to the first end site of a joint.
fn site_length(skeleton: &Skeleton, joint: usize) -> f64 {
    skeleton.joints[joint].end_sites_m.first().map_or(0.0, |end| end.length())
}

fn turns(first: JointSample, other: JointSample) -> bool {
    first.rotation.dot(other.rotation).abs() < 1.0 - 1e-9
}

/// Every how many of so many frames one is looked at.
pub(super) fn step(count: usize) -> usize {
    count.div_ceil(FRAMES_MAX).max(1)
}

/// Which of so many frames are looked at.
fn picked(count: usize) -> Vec<usize> {
    (0..count).step_by(step(count)).collect()
}

/// Bone lengths: of the clip where it moves joints itself, else at rest.
fn lengths(skeleton: &Skeleton, frames: &[Vec<JointSample>], picked: &[usize]) -> Vec<f64> {
    let of = |(joint, described): (usize, &sinew_mocap::SkeletonJoint)| {
        if described.parent.is_none() {
            return 0.0;
        }
        if picked.is_empty() {
            return described.offset_m.length();
        }
        let sum: f64 = picked.iter().map(|frame| frames[*frame][joint].position_m.length()).sum();
        sum / f64::from(u32::try_from(picked.len()).unwrap_or(u32::MAX))
    };
    skeleton.joints.iter().enumerate().map(of).collect()
}
