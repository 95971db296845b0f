//! Tests with the robots of `SINEW_DATA`: their groups, the mirror check, and their poses.

use std::path::PathBuf;

use sinew_retarget::rig::{RigMatch, RigMatchError, mirror_faults, with_axes_turned};
use sinew_retarget::solve::{Settings, bake};
use sinew_retarget::{Landmark, Side, performer::Performer};
use sinew_rig::Mechanism;
use sinew_rig::description::Base;
use sinew_rig::import::{self, Options};

use super::examples;

fn data() -> PathBuf {
    std::env::var_os("SINEW_DATA").expect("SINEW_DATA names the folder of the data").into()
}

fn robot(path: &str, base: Base) -> Mechanism {
    let text = std::fs::read_to_string(data().join(path)).unwrap();
    let options = Options { open_loops: true, repair_inertia: true, ..Options::default() };
    let mut description = import::urdf(&text, &options).unwrap().description;
    description.mount.base = base;
    description.mechanism().unwrap()
}

/// Returns the joints of a landmark, in one line.
fn joints(mechanism: &Mechanism, rig: &RigMatch, landmark: Landmark) -> String {
    let names = rig.joints(landmark).iter().map(|joint| &mechanism.bodies[*joint].joint_name[..]);
    names.collect::<Vec<_>>().join(" ")
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn groups_are_those_of_the_robots() {
    use Landmark::{Ankle, Chest, Elbow, Head, Hip, Knee, Shoulder, Wrist};
    let left = Side::Left;
    let expected: [(&str, &[(Landmark, &str)]); 7] = [
        (
            "urdf/poppy-humanoid/Poppy_Humanoid.urdf",
            &[
                (Chest, "abs_y abs_x abs_z bust_y bust_x"),
                (Head, "head_z head_y"),
                (Hip(left), "l_hip_x l_hip_z l_hip_y"),
                (Knee(left), "l_knee_y"),
                (Ankle(left), "l_ankle_y"),
                (Shoulder(left), "l_shoulder_y l_shoulder_x l_arm_z"),
                (Elbow(left), "l_elbow_y"),
                (Wrist(left), ""),
            ],
        ),
        (
            "urdf/robotis-op3/robotis_op3.urdf",
            &[
                (Chest, ""),
                (Head, "head_pan head_tilt"),
                (Hip(left), "l_hip_yaw l_hip_roll l_hip_pitch"),
                (Knee(left), "l_knee"),
                (Ankle(left), "l_ank_pitch l_ank_roll"),
                (Shoulder(left), "l_sho_pitch l_sho_roll"),
                (Elbow(left), "l_el"),
            ],
        ),
        (
            "urdf/open-duck-mini/open_duck_mini_v2.urdf",
            &[
                (Head, "neck_pitch head_pitch head_yaw head_roll"),
                (Hip(left), "left_hip_yaw left_hip_roll left_hip_pitch"),
                (Knee(left), "left_knee"),
                (Ankle(left), "left_ankle"),
                (Shoulder(left), ""),
            ],
        ),
        (
            "foreign/urdf/h1.urdf",
            &[
                (Chest, "torso_joint"),
                (Hip(left), "left_hip_yaw_joint left_hip_pitch_joint left_hip_roll_joint"),
                (Elbow(left), "left_elbow_joint left_wrist_roll_joint"),
                (Wrist(left), "left_wrist_pitch_joint left_wrist_yaw_joint"),
            ],
        ),
        (
            "foreign/urdf/talos_reduced.urdf",
            &[
                (Chest, "torso_1_joint torso_2_joint"),
                (Hip(left), "leg_left_1_joint leg_left_2_joint leg_left_3_joint"),
                (Knee(left), "leg_left_4_joint"),
                (Ankle(left), "leg_left_5_joint leg_left_6_joint"),
                (Shoulder(left), "arm_left_1_joint arm_left_2_joint arm_left_3_joint"),
                (Elbow(left), "arm_left_4_joint arm_left_5_joint"),
                (Wrist(left), "arm_left_6_joint arm_left_7_joint"),
            ],
        ),
        (
            "foreign/urdf/so100.urdf",
            &[
                (Shoulder(Side::Right), "shoulder_pan shoulder_lift"),
                (Elbow(Side::Right), "elbow_flex"),
                (Wrist(Side::Right), "wrist_flex wrist_roll"),
                (Shoulder(left), ""),
            ],
        ),
        (
            "foreign/urdf/reachy.URDF",
            &[
                (Shoulder(left), "l_shoulder_pitch l_shoulder_roll l_arm_yaw"),
                (Elbow(left), "l_elbow_pitch l_forearm_yaw"),
                (Wrist(left), "l_wrist_pitch l_wrist_roll"),
            ],
        ),
    ];
    for (path, groups) in expected {
        let mechanism = robot(path, Base::Fixed);
        let rig = RigMatch::of(&mechanism).unwrap();
        for (landmark, expected) in groups {
            let found = joints(&mechanism, &rig, *landmark);
            assert_eq!(found, *expected, "{path} {}", landmark.name());
            // The other side has the same number of joints.
            if let Some(partner) = landmark.mirrored().filter(|_| !path.contains("so100")) {
                assert_eq!(rig.joints(partner).len(), rig.joints(*landmark).len(), "{path}");
            }
        }
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn one_knee_of_poppy_is_wrong_in_its_file_and_no_other_joint() {
    for path in [
        "urdf/poppy-humanoid/Poppy_Humanoid.urdf",
        "urdf/robotis-op3/robotis_op3.urdf",
        "urdf/open-duck-mini/open_duck_mini_v2.urdf",
        "foreign/urdf/h1.urdf",
        "foreign/urdf/talos_reduced.urdf",
        "foreign/urdf/reachy.URDF",
    ] {
        let mechanism = robot(path, Base::Fixed);
        let faults = mirror_faults(&mechanism, &RigMatch::of(&mechanism).unwrap());
        let turned: Vec<&str> = faults
            .iter()
            .filter(|fault| fault.is_axis_turned)
            .map(|fault| &mechanism.bodies[fault.joint].joint_name[..])
            .collect();
        if path.contains("poppy") {
            assert_eq!(turned, ["l_knee_y"]);
            let with_axes_turned = with_axes_turned(&mechanism, &faults);
            assert_eq!(
                mirror_faults(&with_axes_turned, &RigMatch::of(&with_axes_turned).unwrap()),
                []
            );
        } else {
            assert_eq!(turned, [""; 0], "{path}");
        }
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn a_platform_and_a_hand_are_no_performers() {
    for path in ["urdf/reachy-mini/reachy_mini.urdf", "foreign/urdf/allegro_left.urdf"] {
        let mechanism = robot(path, Base::Fixed);
        let found = RigMatch::of(&mechanism);
        assert!(matches!(found, Err(RigMatchError::Nothing { .. })), "{path}: {found:?}");
    }
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn h1_walks_and_fights() {
    let mechanism = robot("foreign/urdf/h1.urdf", Base::Driven);
    let rig = RigMatch::of(&mechanism).unwrap();
    for path in ["cmu/walk/07_01.bvh", "cmu/fight/02_05.bvh"] {
        let recording = sinew_mocap::bvh::read(&data().join(path)).unwrap().in_metres(0.056_444);
        let frame_time_s = recording.frame_time_s.unwrap();
        let (mut clip, _) = sinew_mocap::gaps::fill(recording, frame_time_s, 0.5).unwrap();
        // The first frame is a calibration pose.
        clip.frames.remove(0);
        let performer = Performer::of(&clip, &examples::joints(&clip.skeleton)).unwrap();
        let baked = bake(&mechanism, &rig, &clip, &performer, &Settings::default());
        let errors: Vec<f64> =
            baked.limbs.iter().flatten().map(|limb| f64::from(limb.error_rad)).collect();
        let mean_deg = (errors.iter().sum::<f64>() / errors.len() as f64).to_degrees();
        // The goal for rigs that have the joints.
        assert!(mean_deg < 2.5, "{path}: {mean_deg}");
        assert_eq!(errors.len(), 8 * clip.frames.len());
    }
}
