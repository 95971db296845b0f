//! One frame of a performance.

use glam::{DMat3, DQuat, DVec3};
use sinew_mocap::JointSample;

use super::model::Performer;
use crate::{Landmark, LandmarkMap, Side};

/// Rotation by 180 deg about up, in the axes of a part.
const HALF_TURNED: DQuat = DQuat::from_xyzw(0.0, 0.0, 1.0, 0.0);

/// One frame of a performance, in the world: y up, m.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct PerformerFrame {
    /// Positions of the landmarks, m.
    pub points_m: LandmarkMap<Option<DVec3>>,
    /// Orientations of pelvis, chest, head and feet (under their ankles): rotations from forward, left, up (as x,
    /// y, z) to the world.
    pub parts: LandmarkMap<Option<DQuat>>,
    /// Unit axes about which elbows and knees bend, with their certainty from 0 to 1.
    pub bends: LandmarkMap<Option<(DVec3, f64)>>,
}

impl PerformerFrame {
    /// Returns the midpoint between the hips, m; without hips, the pelvis; `None` without either.
    pub fn hips_m(&self) -> Option<DVec3> {
        self.middle_m(Landmark::Hip).or(self.points_m[Landmark::Pelvis])
    }

    /// Returns the midpoint between a landmark's left and right place, m; `None` if a side is missing.
    fn middle_m(&self, landmark: fn(Side) -> Landmark) -> Option<DVec3> {
        let [left, right] = Side::ALL.map(|side| self.points_m[landmark(side)]);
        Some((left? + right?) / 2.0)
    }

    /// Returns the unit direction from one landmark to another; `None` if a landmark is missing, or both are at one
    /// place.
    pub fn direction(&self, from: Landmark, to: Landmark) -> Option<DVec3> {
        (self.points_m[to]? - self.points_m[from]?).try_normalize()
    }

    /// Returns the way from the first to the last landmark of a limb, divided by the length of the limb; `None` if a
    /// landmark is missing, or the limb has no length.
    pub fn reach(&self, [top, middle, end]: [Landmark; 3]) -> Option<DVec3> {
        let [top, middle, end] = [top, middle, end].map(|landmark| self.points_m[landmark]);
        let (top, middle, end) = (top?, middle?, end?);
        let length = top.distance(middle) + middle.distance(end);
        (length > f64::EPSILON).then(|| (end - top) / length)
    }

    /// Returns whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.points_m.iter().all(|(_, point)| point.is_none_or(DVec3::is_finite))
            && self.parts.iter().all(|(_, part)| part.is_none_or(DQuat::is_finite))
            && self.bends.iter().all(|(_, bend)| bend.is_none_or(|(axis, _)| axis.is_finite()))
    }

    /// Returns the frame mirrored at the plane x = 0: left becomes right.
    #[must_use]
    pub fn mirrored(&self) -> Self {
        let flip = |v: DVec3| DVec3::new(-v.x, v.y, v.z);
        let partner = |landmark: Landmark| landmark.mirrored().unwrap_or(landmark);
        Self {
            points_m: LandmarkMap::of(|k| self.points_m[partner(k)].map(flip)),
            // Forward and up are mirrored; left must be reversed, to point to the left again.
            parts: LandmarkMap::of(|k| {
                self.parts[partner(k)].map(|q| DQuat::from_xyzw(q.x, -q.y, -q.z, q.w) * HALF_TURNED)
            }),
            // A mirror reverses the sense of rotations.
            bends: LandmarkMap::of(|k| {
                self.bends[partner(k)].map(|(axis, sure)| (-flip(axis), sure))
            }),
        }
    }

    /// Returns the frame rotated, then translated.
    #[must_use]
    pub fn moved(&self, rotation: DQuat, by_m: DVec3) -> Self {
        Self {
            points_m: LandmarkMap::of(|k| self.points_m[k].map(|point| rotation * point + by_m)),
            parts: LandmarkMap::of(|k| self.parts[k].map(|part| rotation * part)),
            bends: LandmarkMap::of(|k| self.bends[k].map(|(axis, sure)| (rotation * axis, sure))),
        }
    }
}

impl Performer {
    /// Converts a frame of the clip's skeleton. `local` contains the pose of each joint relative to its parent;
    /// `world` is a buffer for as many poses. Landmarks without samples are left out. O(joints), without allocation
    /// once `world` has room.
    pub fn frame(&self, local: &[JointSample], world: &mut Vec<JointSample>) -> PerformerFrame {
        world.clear();
        for (sample, parent) in local.iter().zip(&self.parents) {
            world.push(parent.and_then(|parent| world.get(parent)).map_or(*sample, |parent| {
                JointSample {
                    rotation: parent.rotation * sample.rotation,
                    position_m: parent.position_m + parent.rotation * sample.position_m,
                }
            }));
        }
        let pose = |joint: usize| world.get(joint);
        PerformerFrame {
            points_m: LandmarkMap::of(|landmark| {
                let pose = pose(self.joints.joints[landmark]?)?;
                let end_m = self.joints.head_end_m.filter(|_| landmark == Landmark::Head);
                Some(pose.position_m + pose.rotation * end_m.unwrap_or_default())
            }),
            parts: LandmarkMap::of(|landmark| {
                let point = |place: Landmark| Some(pose(self.joints.joints[place]?)?.position_m);
                if let (Landmark::Chest, Some(upright)) = (landmark, self.trunk) {
                    return Some((trunk(point)? * upright).normalize());
                }
                let part = self.parts[landmark]?;
                Some((pose(part.joint)?.rotation * part.upright).normalize())
            }),
            bends: LandmarkMap::of(|landmark| {
                let bend = self.bends[landmark]?;
                Some((pose(bend.upper)?.rotation * bend.axis, bend.certainty))
            }),
        }
    }
}

/// Returns the orientation of the trunk: left along the shoulders, and up from the hips to the shoulders, made
/// perpendicular to left. `None` if a shoulder or a hip is missing, or the directions are undefined.
pub(super) fn trunk(point: impl Fn(Landmark) -> Option<DVec3>) -> Option<DQuat> {
    let [left_m, right_m] = Side::ALL.map(|side| point(Landmark::Shoulder(side)));
    let [left_hip_m, right_hip_m] = Side::ALL.map(|side| point(Landmark::Hip(side)));
    let (left_m, right_m) = (left_m?, right_m?);
    let left = (left_m - right_m).try_normalize()?;
    let way = (left_m + right_m - left_hip_m? - right_hip_m?) / 2.0;
    let up = way.reject_from_normalized(left).try_normalize()?;
    Some(DQuat::from_mat3(&DMat3::from_cols(left.cross(up), left, up)))
}
