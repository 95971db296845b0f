//! Measures a performer, from a whole clip.

use glam::{DMat3, DQuat, DVec3};
use sinew_mocap::{Clip, JointSample, forward_kinematics};

use super::frame::trunk;
use super::model::{Bend, Part, Performer, PerformerJoints};
use crate::{Landmark, LandmarkMap, Side};

/// Minimum cosine between up and a direction that counts as upright.
const UPRIGHT: f64 = 0.87;
/// Quantile of the toes' heights at which the floor is assumed.
const FLOOR: f64 = 0.02;

pub(super) fn measure(clip: &Clip, joints: &PerformerJoints) -> Performer {
    let point = |world: &[JointSample], landmark: Landmark| {
        joints.joints[landmark].map(|joint| world[joint].position_m)
    };
    let upright = upright_pose(clip, joints);
    let parts = parts(joints, &upright);
    let mut bends = LandmarkMap::of(|landmark| {
        let (above, below) = match landmark {
            Landmark::Elbow(side) => (Landmark::Shoulder(side), Landmark::Wrist(side)),
            Landmark::Knee(side) => (Landmark::Hip(side), Landmark::Ankle(side)),
            _ => return None,
        };
        let [upper, middle, lower] = [above, landmark, below].map(|place| joints.joints[place]);
        Some(Bending::of([upper?, middle?, lower?]))
    });
    let mut toes_m = Vec::new();
    // One frame at a time: the poses of a long clip would need as much memory as the clip.
    for frame in 0..clip.frames.len() {
        let world = clip.world_poses(frame);
        bends.values_mut().flatten().for_each(|bend| bend.add(&world));
        let toes = Side::ALL.into_iter().filter_map(|side| point(&world, Landmark::Toe(side)));
        toes_m.extend(toes.map(|toe_m| toe_m.y));
    }
    let first = clip.world_poses(0);
    let length = |chains: [[Landmark; 3]; 2]| {
        let of_chain = |chain: [Landmark; 3]| {
            let [a, b, c] = chain.map(|landmark| point(&first, landmark));
            Some(a?.distance(b?) + b?.distance(c?))
        };
        let [left, right] = chains.map(of_chain);
        Some(f64::midpoint(left?, right?))
    };
    let legs =
        Side::ALL.map(|side| [Landmark::Hip(side), Landmark::Knee(side), Landmark::Ankle(side)]);
    let arms = Side::ALL
        .map(|side| [Landmark::Shoulder(side), Landmark::Elbow(side), Landmark::Wrist(side)]);
    Performer {
        joints: *joints,
        parts,
        trunk: upright_trunk(joints, &upright),
        bends: LandmarkMap::of(|landmark| bends[landmark].as_ref()?.mean()),
        leg_m: length(legs),
        arm_m: length(arms),
        floor_m: quantile(toes_m, FLOOR),
        parents: clip.skeleton.joints.iter().map(|joint| joint.parent).collect(),
    }
}

/// Returns a pose in which the performer stands upright: the pose of zero rotations if it is upright, otherwise the
/// frame in which trunk and legs are closest to upright.
fn upright_pose(clip: &Clip, joints: &PerformerJoints) -> Vec<JointSample> {
    let still = clip
        .skeleton
        .joints
        .iter()
        .map(|joint| JointSample { rotation: DQuat::IDENTITY, position_m: joint.offset_m });
    let zero = forward_kinematics(&clip.skeleton, &still.collect::<Vec<_>>());
    if uprightness(&zero, joints) > UPRIGHT {
        return zero;
    }
    let nearest = (0..clip.frames.len())
        .map(|frame| (frame, uprightness(&clip.world_poses(frame), joints)))
        .max_by(|a, b| a.1.total_cmp(&b.1));
    nearest.map_or(zero, |(frame, _)| clip.world_poses(frame))
}

/// Returns the smallest cosine between up and the trunk, the head and the legs; 1 if the skeleton has none of them.
fn uprightness(world: &[JointSample], joints: &PerformerJoints) -> f64 {
    let point = |landmark: Landmark| joints.joints[landmark].map(|joint| world[joint].position_m);
    let middle = |landmark: fn(Side) -> Landmark| {
        let [left, right] = Side::ALL.map(|side| point(landmark(side)));
        Some((left? + right?) / 2.0)
    };
    let ways = [
        (middle(Landmark::Hip), middle(Landmark::Shoulder)),
        (middle(Landmark::Knee), middle(Landmark::Hip)),
        (middle(Landmark::Ankle), middle(Landmark::Knee)),
        (middle(Landmark::Shoulder), point(Landmark::Head)),
    ];
    let cosines = ways.into_iter().filter_map(|(from, to)| Some((to? - from?).try_normalize()?.y));
    cosines.fold(1.0, f64::min)
}

/// Measures pelvis, chest, head and feet in an upright pose. `None` for parts that are missing, and for those whose
/// direction to the left is unknown.
fn parts(joints: &PerformerJoints, upright: &[JointSample]) -> LandmarkMap<Option<Part>> {
    let point = |landmark: Landmark| joints.joints[landmark].map(|joint| upright[joint].position_m);
    let across = |landmark: fn(Side) -> Landmark| {
        let [left, right] = Side::ALL.map(|side| point(landmark(side)));
        (left? - right?).with_y(0.0).try_normalize()
    };
    let (hips, shoulders) = (across(Landmark::Hip), across(Landmark::Shoulder));
    LandmarkMap::of(|landmark| {
        let joint = joints.joints[landmark]?;
        let (left, up) = match landmark {
            Landmark::Pelvis => (hips.or(shoulders)?, DVec3::Y),
            Landmark::Chest | Landmark::Head => (shoulders.or(hips)?, DVec3::Y),
            Landmark::Ankle(side) => {
                // A foot is perpendicular to its shank, and the toe points forward.
                let up = (point(Landmark::Knee(side))? - point(landmark)?).try_normalize()?;
                let toe =
                    point(Landmark::Toe(side)).map(|toe| toe - point(landmark).unwrap_or(toe));
                let left = match toe {
                    Some(toe) => up.cross(toe),
                    None => hips?,
                };
                (left.reject_from(up).try_normalize()?, up)
            }
            _ => return None,
        };
        let stands = DMat3::from_cols(left.cross(up), left, up);
        let upright = upright[joint].rotation.conjugate() * DQuat::from_mat3(&stands);
        Some(Part { joint, upright: upright.normalize() })
    })
}

/// Returns the rotation between the trunk's axes and its facing direction in an upright pose; `None` if a shoulder or a
/// hip is missing, or a direction is undefined.
fn upright_trunk(joints: &PerformerJoints, upright: &[JointSample]) -> Option<DQuat> {
    let point = |place: Landmark| Some(upright[joints.joints[place]?].position_m);
    let [left, right] = Side::ALL.map(|side| point(Landmark::Shoulder(side)));
    let left = (left? - right?).with_y(0.0).try_normalize()?;
    let stands = DMat3::from_cols(left.cross(DVec3::Y), left, DVec3::Y);
    Some((trunk(point)?.conjugate() * DQuat::from_mat3(&stands)).normalize())
}

/// Accumulates the mean axis about which a limb bends, in the frame of its upper joint, weighted by the bend.
#[derive(Debug)]
struct Bending {
    /// Upper, middle and lower joint.
    joints: [usize; 3],
    sum: DVec3,
    of_lengths: f64,
}

impl Bending {
    fn of(joints: [usize; 3]) -> Self {
        Self { joints, sum: DVec3::ZERO, of_lengths: 0.0 }
    }

    fn add(&mut self, world: &[JointSample]) {
        let [a, b, c] = self.joints.map(|joint| world[joint].position_m);
        let (Some(above), Some(below)) = ((b - a).try_normalize(), (c - b).try_normalize()) else {
            return;
        };
        let axis = world[self.joints[0]].rotation.conjugate() * above.cross(below);
        self.sum += axis;
        self.of_lengths += axis.length();
    }

    fn mean(&self) -> Option<Bend> {
        let axis = self.sum.try_normalize()?;
        Some(Bend { upper: self.joints[0], axis, certainty: self.sum.length() / self.of_lengths })
    }
}

/// Returns the value below which a share of all values is; 0 without values.
fn quantile(mut values: Vec<f64>, part: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place in the list"
    )]
    let place = (part * values.len().saturating_sub(1) as f64) as usize;
    values.get(place).copied().unwrap_or(0.0)
}
