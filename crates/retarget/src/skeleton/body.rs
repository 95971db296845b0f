//! A skeleton with the data that its matching uses: names, tree, lengths, poses.

use glam::DVec3;
use sinew_mocap::{JointSample, Skeleton, forward_kinematics};

use super::name::{Kind, Name, read_all};

/// Maximum number of frames of a clip that are evaluated, evenly spread.
const FRAMES_MAX: usize = 48;
/// Minimum length of a bone with a direction, as a share of the skeleton. A shorter bone only carries a joint.
const ZERO: f64 = 2e-3;
/// If some joint in a clip bends by at least this angle, rad, it is significant that another joint does not bend.
const MOVES_RAD: f64 = 0.4;
/// Maximum angle between bones of one line, rad: rest poses have kinks of a few degrees.
const STRAIGHT_RAD: f64 = 0.2;

/// A skeleton with analysed names and measured bones.
pub(super) struct Body<'a> {
    pub skeleton: &'a Skeleton,
    pub names: Vec<Name>,
    pub children: Vec<Vec<usize>>,
    /// Length of the bone from the parent, in the skeleton's unit. It does not depend on the pose.
    pub lengths: Vec<f64>,
    /// Whether the bones before and after a joint remain in one line while others bend: such a joint only twists.
    pub stays_straight: Vec<bool>,
    /// Length of the longest path outwards from each joint, including end sites.
    pub below: Vec<f64>,
    /// Whether a joint is only the end of a bone.
    pub is_end: Vec<bool>,
    /// Positions of all joints: first in the rest pose, then in frames of the clip.
    pub poses: Vec<Pose>,
}

/// Positions of all joints at one time.
pub(super) struct Pose {
    /// Index of the frame; `None` for the rest pose.
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
            // A joint without children that never turns: most writers add such a joint at the end of a bone.
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

    /// Returns a joint, its parent, and so on to the root.
    pub(super) fn upwards(&self, joint: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(joint), |joint| self.parent(*joint))
    }

    /// Returns whether `joint` is `ancestor`, or a descendant of it.
    pub(super) fn hangs_on(&self, joint: usize, ancestor: usize) -> bool {
        // Parents precede their children.
        self.upwards(joint).take_while(|other| *other >= ancestor).last() == Some(ancestor)
    }

    /// Returns the last common ancestor of two joints.
    pub(super) fn common_ancestor(&self, mut a: usize, mut b: usize) -> usize {
        while a != b {
            // The joint with the larger index is not an ancestor of the other joint.
            let later = if a > b { &mut a } else { &mut b };
            *later = self.parent(*later).unwrap_or(0);
        }
        a
    }

    /// Returns the joints from `ancestor` (not included) to `joint`, which is a descendant of it.
    pub(super) fn way(&self, ancestor: usize, joint: usize) -> Vec<usize> {
        let mut way: Vec<usize> =
            self.upwards(joint).take_while(|other| *other != ancestor).collect();
        way.reverse();
        way
    }

    /// Returns the sum of bone lengths from `ancestor` to `joint`.
    pub(super) fn length(&self, ancestor: usize, joint: usize) -> f64 {
        self.upwards(joint)
            .take_while(|other| *other != ancestor)
            .map(|other| self.lengths[other])
            .sum()
    }

    /// Returns whether the joint is at the position of its parent.
    pub(super) fn is_at_parent(&self, joint: usize) -> bool {
        self.is_zero(self.lengths[joint])
    }

    /// Returns whether a joint is a helper of no length: it is at the place of a joint that carries other bones too,
    /// and carries a bone itself. CMU's `LHipJoint`, between `Hips` and `LeftUpLeg`, is one.
    pub(super) fn is_helper(&self, joint: usize) -> bool {
        let is_on = |joint: usize| self.parent(joint).filter(|_| self.is_at_parent(joint));
        let Some(parent) = is_on(joint) else { return false };
        let carrier = std::iter::successors(Some(parent), |joint| is_on(*joint)).last();
        let is_bone = |child: &&usize| !self.is_zero(self.lengths[**child] + self.below[**child]);
        let carries =
            carrier.map_or(0, |carrier| self.children[carrier].iter().filter(is_bone).count());
        carries > 1 && self.children[joint].iter().any(|child| !self.is_at_parent(*child))
    }

    /// Returns the length to the joint's first end site; 0 without an end site.
    pub(super) fn site(&self, joint: usize) -> f64 {
        site_length(self.skeleton, joint)
    }

    pub(super) fn is_zero(&self, length: f64) -> bool {
        length <= ZERO * self.below[0]
    }

    /// Returns the smallest and the largest angle in the clip between the bones before and after a joint, rad. `None`
    /// if one of the bones is missing or has no length, or there are no frames.
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

/// Returns the angle between two directions, rad; its bits are equal on every machine.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// Returns the length to the first end site of a joint.
fn site_length(skeleton: &Skeleton, joint: usize) -> f64 {
    skeleton.joints[joint].end_sites_m.first().map_or(0.0, |end| end.length())
}

fn turns(first: JointSample, other: JointSample) -> bool {
    first.rotation.dot(other.rotation).abs() < 1.0 - 1e-9
}

/// Returns the step between evaluated frames, for a clip with `count` frames.
pub(super) fn step(count: usize) -> usize {
    count.div_ceil(FRAMES_MAX).max(1)
}

/// Returns the indices of the evaluated frames.
fn picked(count: usize) -> Vec<usize> {
    (0..count).step_by(step(count)).collect()
}

/// Returns bone lengths: those in the clip if it has frames, otherwise those at rest.
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
