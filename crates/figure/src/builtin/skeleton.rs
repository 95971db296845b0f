//! The fighter's skeleton and its poses.
//!
//! The skeleton is an adult man of 1.78 m. Segment lengths: P. de Leva, "Adjustments to Zatsiorsky-Seluyanov's
//! segment inertia parameters", J. Biomechanics 29 (1996), 1223-1230, table 4, males (mean stature 1.741 m).
//! Heights and breadths that are not in that table: D. A. Winter, *Biomechanics and Motor Control of Human
//! Movement*, figure 4.1 (Drillis and Contini). Distance of the hip centres: A. L. Bell, D. R. Pedersen and R. A.
//! Brand, J. Biomechanics 23 (1990), 617-621.
//!
//! Rest pose: T-pose, palms down, facing +z with the left side at +x. All frames are parallel to the world's.

use std::sync::LazyLock;

use glam::{DQuat, DVec3};
use sinew_mocap::{Skeleton, SkeletonJoint};

use crate::{BODIES, BODY_COUNT};

const STATURE_M: f64 = 1.78;
/// Scale from de Leva's mean man to this one.
const SCALE: f64 = STATURE_M / 1.741;

/// Length from mid-hip to omphalion (navel).
const PELVIS_M: f64 = 0.1457 * SCALE;
/// Length from omphalion to xiphoid (lower end of the breastbone).
const ABDOMEN_M: f64 = 0.2155 * SCALE;
/// Length from xiphoid to suprasternale, which is level with the sternal ends of the clavicles.
const STERNUM_M: f64 = 0.1707 * SCALE;
/// Vector from xiphoid to cervicale, which is 35 mm farther back.
const NECK_M: DVec3 = DVec3::new(0.0, 0.2165 * SCALE, -0.035);
/// Vector from cervicale to vertex, which is 40 mm farther forward.
const HEAD_M: DVec3 = DVec3::new(0.0, 0.2395 * SCALE, 0.040);
/// Length from shoulder to elbow.
pub(super) const UPPER_ARM_M: f64 = 0.2817 * SCALE;
/// Length from elbow to wrist.
pub(super) const FOREARM_M: f64 = 0.2689 * SCALE;
/// Length from wrist to third knuckle: the hand is a fist.
const FIST_M: f64 = 0.0862 * SCALE;
/// Distance of the sternal end of a clavicle from the middle.
const STERNAL_END_M: f64 = 0.025;
/// Distance of a shoulder joint from the middle: half the breadth of the acromia, 0.129 statures, minus 3 cm to
/// the centre of the joint.
const HALF_SHOULDERS_M: f64 = 0.129 * STATURE_M - 0.030;
/// Half the distance of the hip centres.
const HALF_HIPS_M: f64 = 0.087;
/// Length from hip to knee.
pub(super) const THIGH_M: f64 = 0.4222 * SCALE;
/// Length from knee to ankle.
pub(super) const SHANK_M: f64 = 0.4340 * SCALE;
/// Height of the ankle above the sole (0.039 statures).
pub(super) const ANKLE_HEIGHT_M: f64 = 0.039 * STATURE_M;
/// Distance of the ball of the foot in front of the ankle.
pub(super) const ANKLE_TO_BALL_M: f64 = 0.130;
/// Middle of the toe cap, relative to the ankle. A foot is 0.2581 * 1.022 = 0.264 m long, a quarter of it behind
/// the ankle.
const TOE_M: DVec3 = DVec3::new(0.0, 0.020 - ANKLE_HEIGHT_M, 0.198);

/// Length of the arm from shoulder to wrist.
pub(super) const ARM_M: f64 = UPPER_ARM_M + FOREARM_M;
/// Length of the leg from hip to ankle.
pub(super) const LEG_M: f64 = THIGH_M + SHANK_M;

pub(super) const PELVIS: usize = 0;
pub(super) const ABDOMEN: usize = 1;
pub(super) const THORAX: usize = 2;
pub(super) const HEAD: usize = 3;

/// A side of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// The side at +x in the rest pose.
    Left,
    /// The side at -x in the rest pose.
    Right,
}

impl Side {
    /// Both sides, left first.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// Returns the opposite side.
    #[must_use]
    pub const fn opposite(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// Returns +1 for the left, -1 for the right: the sign of x in the rest pose.
    pub const fn sign(self) -> f64 {
        match self {
            Self::Left => 1.0,
            Self::Right => -1.0,
        }
    }

    /// Returns the side's index in arrays of two: left 0, right 1.
    pub const fn index(self) -> usize {
        self as usize
    }

    /// Returns the index of the clavicle. Upper arm, forearm and hand follow it.
    pub const fn clavicle(self) -> usize {
        [4, 8][self.index()]
    }

    /// Returns the index of the hand.
    pub const fn hand(self) -> usize {
        self.clavicle() + 3
    }

    /// Returns the index of the thigh. Shank and foot follow it.
    pub const fn thigh(self) -> usize {
        [12, 15][self.index()]
    }

    /// Returns the index of the foot.
    pub const fn foot(self) -> usize {
        self.thigh() + 2
    }
}

/// Returns the position of joint `body` in its parent's frame.
pub(super) fn offset_m(body: usize) -> DVec3 {
    static OFFSETS_M: LazyLock<[DVec3; BODY_COUNT]> =
        LazyLock::new(|| std::array::from_fn(named_offset_m));
    OFFSETS_M[body]
}

/// Computes [`offset_m`] from the body's name.
fn named_offset_m(body: usize) -> DVec3 {
    let (segment, x) = segment(body);
    match segment {
        "pelvis" => DVec3::ZERO,
        "abdomen" => DVec3::Y * PELVIS_M,
        "thorax" => DVec3::Y * ABDOMEN_M,
        "head" => NECK_M,
        "clavicle" => DVec3::new(x * STERNAL_END_M, STERNUM_M, 0.020),
        "upper_arm" => DVec3::new(x * (HALF_SHOULDERS_M - STERNAL_END_M), -0.010, -0.040),
        "forearm" => DVec3::X * (x * UPPER_ARM_M),
        "hand" => DVec3::X * (x * FOREARM_M),
        "thigh" => DVec3::X * (x * HALF_HIPS_M),
        "shank" => DVec3::NEG_Y * THIGH_M,
        "foot" => DVec3::NEG_Y * SHANK_M,
        other => unreachable!("the figure has no {other}"),
    }
}

/// Returns the end of a leaf segment in its own frame: vertex, third knuckle or toe cap. `None` for other bodies.
pub(super) fn end_site_m(body: usize) -> Option<DVec3> {
    let (segment, x) = segment(body);
    match segment {
        "head" => Some(HEAD_M),
        "hand" => Some(DVec3::X * (x * FIST_M)),
        "foot" => Some(TOE_M),
        _ => None,
    }
}

/// Returns the name of a body without its side, and the sign of the side (0 for bodies of the trunk).
fn segment(body: usize) -> (&'static str, f64) {
    let name = BODIES[body].name;
    match (name.strip_suffix("_l"), name.strip_suffix("_r")) {
        (Some(segment), _) => (segment, Side::Left.sign()),
        (_, Some(segment)) => (segment, Side::Right.sign()),
        (None, None) => (name, 0.0),
    }
}

/// Returns the skeleton of every built-in clip: the figure's bodies, with the same names in the same order.
pub(super) fn skeleton() -> Skeleton {
    let joints = BODIES
        .iter()
        .enumerate()
        .map(|(body, place)| SkeletonJoint {
            name: place.name.to_owned(),
            parent: place.parent,
            offset_m: offset_m(body),
            end_sites_m: end_site_m(body).into_iter().collect(),
        })
        .collect();
    Skeleton { joints }
}

/// Pose of a body in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    /// Rotation from the body's frame to the world's, unit.
    pub rotation: DQuat,
    /// Position of the joint in the world, in metres.
    pub origin_m: DVec3,
}

impl Frame {
    /// Returns the world position of a point of the body.
    pub(super) fn point(&self, local_m: DVec3) -> DVec3 {
        self.origin_m + self.rotation * local_m
    }

    /// Returns the frame of a child joint that is turned by `rotation` relative to this body.
    pub(super) fn child(&self, body: usize, rotation: DQuat) -> Self {
        Self {
            rotation: (self.rotation * rotation).normalize(),
            origin_m: self.point(offset_m(body)),
        }
    }
}

/// One pose of the figure.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Pose {
    /// World position of the pelvis, in metres.
    pub root_m: DVec3,
    /// Rotation from each body to its parent (the pelvis: to the world), unit.
    pub rotation: Vec<DQuat>,
}

impl Pose {
    /// Returns the frames of all bodies in the world.
    #[cfg(test)]
    pub(super) fn world(&self) -> Vec<Frame> {
        let mut frames =
            vec![Frame { rotation: self.rotation[PELVIS], origin_m: self.root_m }; BODIES.len()];
        for (body, place) in BODIES.iter().enumerate() {
            if let Some(parent) = place.parent {
                frames[body] = frames[parent].child(body, self.rotation[body]);
            }
        }
        frames
    }

    /// Returns the pose seen in a mirror in the plane x = 0: left and right change places.
    pub(super) fn mirrored(&self) -> Self {
        let mut rotation: Vec<_> = self.rotation.iter().copied().map(mirror_rotation).collect();
        for segment in 0..4 {
            rotation.swap(Side::Left.clavicle() + segment, Side::Right.clavicle() + segment);
        }
        for segment in 0..3 {
            rotation.swap(Side::Left.thigh() + segment, Side::Right.thigh() + segment);
        }
        Self { root_m: mirror_point(self.root_m), rotation }
    }
}

/// Mirrors a point or a direction in the plane x = 0.
pub(super) fn mirror_point(point: DVec3) -> DVec3 {
    DVec3::new(-point.x, point.y, point.z)
}

/// Mirrors a rotation in the plane x = 0. Angles about the axes obey this rule too.
fn mirror_rotation(rotation: DQuat) -> DQuat {
    DQuat::from_xyzw(rotation.x, -rotation.y, -rotation.z, rotation.w)
}

/// Mirrors a rotation (angles about x, y, z) to the other side of the body.
pub(super) fn mirror_turn(turn: DVec3) -> DVec3 {
    DVec3::new(turn.x, -turn.y, -turn.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_name_the_bodies_they_claim() {
        let name = |body: usize| BODIES[body].name;
        assert_eq!(
            [PELVIS, ABDOMEN, THORAX, HEAD].map(name),
            ["pelvis", "abdomen", "thorax", "head"]
        );
        assert_eq!(Side::BOTH.map(|side| name(side.clavicle())), ["clavicle_l", "clavicle_r"]);
        assert_eq!(Side::BOTH.map(|side| name(side.hand())), ["hand_l", "hand_r"]);
        assert_eq!(Side::BOTH.map(|side| name(side.thigh())), ["thigh_l", "thigh_r"]);
        assert_eq!(Side::BOTH.map(|side| name(side.foot())), ["foot_l", "foot_r"]);
    }

    #[test]
    fn rest_pose_stands_as_tall_as_the_man() {
        let rest =
            Pose { root_m: DVec3::ZERO, rotation: vec![DQuat::IDENTITY; BODY_COUNT] }.world();
        let top = rest[HEAD].point(HEAD_M).y;
        let sole = rest[Side::Left.foot()].origin_m.y - ANKLE_HEIGHT_M;
        assert!((top - sole - STATURE_M).abs() < 0.005, "{}", top - sole);
    }

    #[test]
    fn mirroring_twice_changes_nothing_and_once_swaps_the_hands() {
        let mut pose =
            Pose { root_m: DVec3::new(0.3, 0.9, 0.1), rotation: vec![DQuat::IDENTITY; BODY_COUNT] };
        pose.rotation[Side::Left.clavicle() + 1] =
            DQuat::from_rotation_z(0.5) * DQuat::from_rotation_y(0.3);
        pose.rotation[PELVIS] = DQuat::from_rotation_y(0.4);
        assert_eq!(pose.mirrored().mirrored(), pose);
        let hand = pose.world()[Side::Left.hand()].origin_m;
        let image = pose.mirrored().world()[Side::Right.hand()].origin_m;
        assert!((mirror_point(hand) - image).length() < 1e-14);
    }
}
