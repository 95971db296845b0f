//! A figure of revolute joints and a walking performer. y points up, and both face along z.

use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint};
use sinew_retarget::performer::PerformerJoints;
use sinew_retarget::{Landmark, LandmarkMap, Side};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link};

/// Returns the axis of the mirror image, at x = 0, of a rotation about `a`.
pub(crate) fn mirrored_axis(a: DVec3) -> DVec3 {
    DVec3::new(a.x, -a.y, -a.z)
}

/// Creates a humanoid of 21 hinges on a free base. Its sides are mirror images: equal angles give mirrored poses.
pub(crate) fn figure(range_rad: f64, speed: f64) -> Mechanism {
    let mut bodies = vec![Link {
        name: "pelvis".to_owned(),
        joint_name: "pelvis".to_owned(),
        ..Link::on(None, JointModel::Free, DVec3::ZERO)
    }];
    let mut add = |name: &str, parent: usize, axis: DVec3, position_m: DVec3, range: [f64; 2]| {
        bodies.push(Link {
            name: format!("{name}_link"),
            joint_name: name.to_owned(),
            mass_kg: 0.3,
            ranges: vec![range.map(|end: f64| end.clamp(-range_rad, range_rad))],
            speed,
            ..Link::on(Some(parent), JointModel::Revolute(axis), position_m)
        });
        bodies.len() - 1
    };
    let chest = add("waist_yaw", 0, DVec3::Y, DVec3::Y * 0.1, [-1.0, 1.0]);
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let at = |x: f64, y: f64| DVec3::new(sign * x, y, 0.0);
        let axis = |a: DVec3| if sign > 0.0 { a } else { mirrored_axis(a) };
        let mut chain = |first: usize, joints: &[(&str, DVec3, DVec3, [f64; 2])]| {
            joints.iter().fold(first, |parent, (name, a, position_m, range)| {
                add(&format!("{side}_{name}"), parent, axis(*a), *position_m, *range)
            })
        };
        chain(
            0,
            &[
                ("hip_pitch", DVec3::X, at(0.06, -0.02), [-2.0, 2.0]),
                ("hip_roll", DVec3::Z, DVec3::ZERO, [-0.5, 1.5]),
                ("hip_yaw", DVec3::Y, DVec3::ZERO, [-1.5, 1.5]),
                ("knee", DVec3::X, DVec3::Y * -0.2, [0.0, 2.4]),
                ("ankle_pitch", DVec3::X, DVec3::Y * -0.2, [-1.0, 1.0]),
                ("ankle_roll", DVec3::Z, DVec3::ZERO, [-0.6, 0.6]),
            ],
        );
        chain(
            chest,
            &[
                ("shoulder_pitch", DVec3::X, at(0.12, 0.25), [-3.0, 1.5]),
                ("shoulder_roll", DVec3::Z, DVec3::ZERO, [-0.3, 3.0]),
                ("shoulder_yaw", DVec3::Y, DVec3::ZERO, [-1.6, 1.6]),
                ("elbow", DVec3::X, DVec3::Y * -0.15, [-2.4, 0.0]),
            ],
        );
    }
    for link in &mut bodies {
        // Feet have a front edge, and forearms an end.
        if link.joint_name.ends_with("ankle_roll") {
            link.center_of_mass_m = DVec3::new(0.0, -0.03, 0.03);
            let (xx, yy, zz) = (2.2e-4, 2.4e-4, 0.6e-4);
            link.inertia_kg_m2 = glam::DMat3::from_diagonal(DVec3::new(xx, yy, zz));
        }
        if link.joint_name.ends_with("elbow") {
            link.center_of_mass_m = DVec3::Y * -0.07;
        }
    }
    Mechanism { bodies, linked: Vec::new() }
}

/// Motion of the performer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Gait {
    /// Largest swing of a limb, rad.
    pub(crate) swing_rad: f64,
    /// Step frequency, Hz.
    pub(crate) steps_hz: f64,
    /// Additional angle of the left arm, rad.
    pub(crate) lean_rad: f64,
}

impl Default for Gait {
    fn default() -> Self {
        Self { swing_rad: 0.4, steps_hz: 1.0, lean_rad: 0.3 }
    }
}

/// Creates a clip of a performer of 1.7 m who walks along z for `seconds`, at 120 Hz.
pub(crate) fn walk(gait: Gait, seconds: f64) -> Clip {
    let mut joints = Vec::new();
    let mut add = |name: &str, parent: Option<usize>, offset_m: [f64; 3]| {
        joints.push(SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m: DVec3::from_array(offset_m),
            end_sites_m: Vec::new(),
        });
        joints.len() - 1
    };
    let hips = add("Hips", None, [0.0, 0.95, 0.0]);
    let chest = add("Spine1", Some(hips), [0.0, 0.25, 0.0]);
    add("Head", Some(chest), [0.0, 0.35, 0.0]);
    for (side, sign) in [("Left", 1.0), ("Right", -1.0)] {
        let thigh = add(&format!("{side}UpLeg"), Some(hips), [sign * 0.09, -0.05, 0.0]);
        let shank = add(&format!("{side}Leg"), Some(thigh), [0.0, -0.42, 0.0]);
        let foot = add(&format!("{side}Foot"), Some(shank), [0.0, -0.42, 0.0]);
        add(&format!("{side}ToeBase"), Some(foot), [0.0, -0.05, 0.13]);
        let upper = add(&format!("{side}Arm"), Some(chest), [sign * 0.18, 0.25, 0.0]);
        let fore = add(&format!("{side}ForeArm"), Some(upper), [sign * 0.28, 0.0, 0.0]);
        add(&format!("{side}Hand"), Some(fore), [sign * 0.25, 0.0, 0.0]);
    }
    let skeleton = Skeleton { joints };
    let frame_time_s = 1.0 / 120.0;
    let frame = |k: usize| {
        let t = k as f64 * frame_time_s;
        let phase = std::f64::consts::TAU * gait.steps_hz * t;
        let pose = |joint: &SkeletonJoint| {
            let (sign, name) =
                match (joint.name.strip_prefix("Left"), joint.name.strip_prefix("Right")) {
                    (Some(name), _) => (1.0, name),
                    (_, Some(name)) => (-1.0, name),
                    _ => (0.0, joint.name.as_str()),
                };
            let swing = gait.swing_rad * sign * libm::sin(phase);
            let bend = gait.swing_rad * (1.2 + sign * libm::cos(phase));
            let rotation = match name {
                "UpLeg" => DQuat::from_rotation_x(-swing) * DQuat::from_rotation_z(0.05 * sign),
                "Leg" => DQuat::from_rotation_x(bend),
                "Foot" => DQuat::from_rotation_x(swing - bend),
                "Arm" => {
                    let more = if sign > 0.0 { gait.lean_rad } else { 0.0 };
                    DQuat::from_rotation_x(swing) * DQuat::from_rotation_z(-sign * (1.3 - more))
                }
                "ForeArm" => DQuat::from_rotation_y(-sign * (0.3 + bend)),
                "Spine1" => DQuat::from_rotation_y(0.2 * libm::sin(phase)),
                _ => DQuat::IDENTITY,
            };
            let mut position_m = joint.offset_m;
            if name == "Hips" {
                position_m += DVec3::new(0.0, -0.03 * libm::cos(2.0 * phase), 0.8 * t);
            }
            JointSample { rotation, position_m }
        };
        skeleton.joints.iter().map(pose).collect()
    };
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a few seconds")]
    let count = (seconds / frame_time_s) as usize;
    Clip {
        name: "walk".to_owned(),
        frame_time_s,
        frames: (0..count).map(frame).collect(),
        skeleton,
    }
}

/// Returns the joints of the landmarks in a skeleton with CMU's names.
pub(crate) fn joints(skeleton: &Skeleton) -> PerformerJoints {
    let name = |landmark: Landmark| {
        let side = |side| if side == Side::Left { "Left" } else { "Right" };
        match landmark {
            Landmark::Pelvis => "Hips".to_owned(),
            Landmark::Chest => "Spine1".to_owned(),
            Landmark::Neck => "Neck1".to_owned(),
            Landmark::Head => "Head".to_owned(),
            Landmark::Shoulder(s) => format!("{}Arm", side(s)),
            Landmark::Elbow(s) => format!("{}ForeArm", side(s)),
            Landmark::Wrist(s) => format!("{}Hand", side(s)),
            Landmark::Hip(s) => format!("{}UpLeg", side(s)),
            Landmark::Knee(s) => format!("{}Leg", side(s)),
            Landmark::Ankle(s) => format!("{}Foot", side(s)),
            Landmark::Toe(s) => format!("{}ToeBase", side(s)),
        }
    };
    PerformerJoints::of(skeleton, LandmarkMap::of(|landmark| skeleton.find(&name(landmark))))
}
