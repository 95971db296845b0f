//! Search and blend with all kinds of skeletons.

use std::path::Path;

use glam::{DQuat, DVec3};
use sinew_mocap::{Clip, JointSample, Skeleton, SkeletonJoint, bvh};

use super::json;
use crate::common::{sinew_in, text};

/// A moving creature with a number of joints, each with two children. The last `still` joints do not move.
pub(super) fn creature(joints: usize, still: usize) -> Clip {
    let joint = |index: usize| SkeletonJoint {
        name: format!("feeler_{index}"),
        parent: index.checked_sub(1).map(|before| before / 2),
        offset_m: DVec3::new(0.1, 0.02 * (index % 2) as f64, 0.01 * (index % 5) as f64),
        end_sites_m: Vec::new(),
    };
    let skeleton = Skeleton { joints: (0..joints).map(joint).collect() };
    let sample = |frame: usize, index: usize| JointSample {
        rotation: if index < joints - still {
            DQuat::from_rotation_z(0.3 * libm::sin(0.2 * frame as f64 + index as f64))
        } else {
            DQuat::from_rotation_x(0.1)
        },
        position_m: skeleton.joints[index].offset_m,
    };
    let frames = (0..60).map(|frame| (0..joints).map(|index| sample(frame, index)).collect());
    Clip {
        name: "creature".into(),
        frames: frames.collect(),
        skeleton: skeleton.clone(),
        frame_time_s: 1.0 / 30.0,
    }
}

#[test]
fn any_skeleton_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    for (joints, still) in [(12, 0), (200, 0), (300, 100)] {
        bvh::write(&folder.path().join("a.bvh"), &creature(joints, still), 0.01).expect("a clip");
        let arguments =
            ["clip", "find", "a.bvh", "--like", "a.bvh@20", "--check", "--apart-s", "0.2"];
        for metric in ["positions", "line"] {
            let (found, told) =
                json(folder.path(), &[&arguments[..], &["--metric", metric]].concat());
            assert!(told.contains("checked: the same moments"), "{told}");
            // All joints swing at 0.2 rad per frame: a period of 31.4 frames.
            assert_eq!(found["moments"][0]["frame"], 51, "{found}");
        }
    }
    let blend = [
        "clip",
        "blend",
        "a.bvh@15",
        "a.bvh@40",
        "--output",
        "b.bvh",
        "--blend-s",
        "0.2",
        "--alone-s",
        "0",
    ];
    bvh::write(&folder.path().join("a.bvh"), &creature(40, 10), 0.01).expect("a clip");
    let (blended, _) = json(folder.path(), &blend);
    assert!(blended["geodesic_m"].as_f64().is_some_and(|length_m| length_m > 0.0), "{blended}");
    let read = bvh::read(&folder.path().join("b.bvh")).expect("a clip");
    assert_eq!(read.skeleton.joints.len(), 40);
    let drawn = sinew_in(folder.path(), &[&blend[..], &["--picture", "b.svg"]].concat());
    assert!(
        text(&drawn.stderr).contains("expected a human (other skeletons are not drawn)"),
        "{}",
        text(&drawn.stderr)
    );
    bvh::write(&folder.path().join("a.bvh"), &creature(300, 20), 0.01).expect("a clip");
    let refused = sinew_in(folder.path(), &["clip", "find", "a.bvh", "--like", "a.bvh@20"]);
    let told = text(&refused.stderr);
    assert!(told.contains("expected at most 256 joints that move, found 2"), "{told}");
}

/// A trotting dog. Its joints have the names of capture software: those of a human, and a tail.
fn dog() -> Clip {
    const JOINTS: [(&str, &str, [f64; 3]); 23] = [
        ("Hips", "", [0.0, 0.45, 0.0]),
        ("Spine", "Hips", [0.0, 0.02, 0.15]),
        ("Spine1", "Spine", [0.0, 0.02, 0.2]),
        ("Neck", "Spine1", [0.0, 0.08, 0.12]),
        ("Head", "Neck", [0.0, 0.1, 0.12]),
        ("LeftShoulder", "Spine1", [0.05, 0.03, 0.05]),
        ("LeftArm", "LeftShoulder", [0.03, -0.08, 0.03]),
        ("LeftForeArm", "LeftArm", [0.0, -0.16, -0.03]),
        ("LeftHand", "LeftForeArm", [0.0, -0.2, 0.0]),
        ("RightShoulder", "Spine1", [-0.05, 0.03, 0.05]),
        ("RightArm", "RightShoulder", [-0.03, -0.08, 0.03]),
        ("RightForeArm", "RightArm", [0.0, -0.16, -0.03]),
        ("RightHand", "RightForeArm", [0.0, -0.2, 0.0]),
        ("LeftUpLeg", "Hips", [0.06, -0.03, -0.05]),
        ("LeftLeg", "LeftUpLeg", [0.0, -0.18, 0.04]),
        ("LeftFoot", "LeftLeg", [0.0, -0.17, -0.06]),
        ("RightUpLeg", "Hips", [-0.06, -0.03, -0.05]),
        ("RightLeg", "RightUpLeg", [0.0, -0.18, 0.04]),
        ("RightFoot", "RightLeg", [0.0, -0.17, -0.06]),
        ("Tail", "Hips", [0.0, 0.03, -0.1]),
        ("Tail1", "Tail", [0.0, 0.0, -0.12]),
        ("Tail2", "Tail1", [0.0, 0.0, -0.12]),
        ("Tail3", "Tail2", [0.0, 0.0, -0.12]),
    ];
    let joint = |(name, parent, offset_m): &(&str, &str, [f64; 3])| SkeletonJoint {
        name: (*name).into(),
        parent: JOINTS.iter().position(|(other, ..)| other == parent),
        offset_m: DVec3::from_array(*offset_m),
        end_sites_m: if matches!(*name, "Head" | "Tail3") {
            vec![DVec3::new(0.0, 0.0, 0.1)]
        } else {
            Vec::new()
        },
    };
    let skeleton = Skeleton { joints: JOINTS.iter().map(joint).collect() };
    // A stride takes 20 frames; diagonal legs move together.
    let sample = |frame: usize, index: usize| {
        let name = JOINTS[index].0;
        let phase = core::f64::consts::TAU * frame as f64 / 20.0;
        let across = matches!(name, "LeftArm" | "LeftForeArm" | "RightUpLeg" | "RightLeg");
        let swing = libm::sin(if across { phase } else { phase + core::f64::consts::PI });
        let rotation = match name {
            "Tail" | "Tail1" | "Tail2" | "Tail3" => DQuat::from_rotation_y(0.2 * swing),
            "Hips" => DQuat::from_rotation_y(0.03 * swing),
            _ if name.contains("Arm") || name.contains("Leg") => {
                DQuat::from_rotation_x(0.4 * swing)
            }
            _ => DQuat::from_rotation_x(0.05 * libm::cos(phase)),
        };
        let ahead_m = if index == 0 { 0.04 * frame as f64 } else { 0.0 };
        let position_m = skeleton.joints[index].offset_m + DVec3::Z * ahead_m;
        JointSample { rotation, position_m }
    };
    let frames = (0..90).map(|frame| (0..JOINTS.len()).map(|index| sample(frame, index)).collect());
    Clip {
        name: "dog".into(),
        frames: frames.collect(),
        frame_time_s: 1.0 / 30.0,
        skeleton: skeleton.clone(),
    }
}

#[test]
fn a_quadruped_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    bvh::write(&folder.path().join("dog.bvh"), &dog(), 0.01).expect("a clip");
    for metric in ["positions", "line", "angles", "rotations"] {
        let arguments =
            ["clip", "find", "dog.bvh", "--like", "dog.bvh@33", "--check", "--metric", metric];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // The found frame is a stride earlier or later.
        let frame = found["moments"][0]["frame"].as_u64().expect("a frame");
        assert!([13, 53, 73].contains(&frame), "{metric}: {found}");
        assert!(found["moments"][0]["distance"].as_f64().unwrap() < 1e-3, "{found}");
    }
    let blend = [
        "clip",
        "blend",
        "dog.bvh@20..30",
        "dog.bvh@52..58",
        "--output",
        "b.bvh",
        "--blend-s",
        "0.4",
    ];
    let (blended, _) = json(folder.path(), &blend);
    let number = |name: &str| blended[name].as_f64().expect("a number");
    assert_eq!(blended["not_converged"], 0, "{blended}");
    // The places have different phases of the stride, so the distance is not zero.
    assert!(number("geodesic_m") > 0.01, "{blended}");
    assert!(number("positions_m") <= number("geodesic_m"), "{blended}");
    assert!(number("geodesic_m") <= number("line_m") * (1.0 + 1e-3), "{blended}");
    let read = bvh::read(&folder.path().join("b.bvh")).expect("a clip");
    assert_eq!(read.skeleton.joints.len(), 23);
}

/// A chain of joints that all swing.
fn chain(joints: usize) -> Clip {
    let joint = |index: usize| SkeletonJoint {
        name: format!("link_{index}"),
        parent: index.checked_sub(1),
        offset_m: DVec3::Y * 0.02,
        end_sites_m: Vec::new(),
    };
    let skeleton = Skeleton { joints: (0..joints).map(joint).collect() };
    let sample = |frame: usize, index: usize| JointSample {
        rotation: DQuat::from_rotation_z(
            0.05 * libm::sin(core::f64::consts::TAU * frame as f64 / 30.0 + 0.3 * index as f64),
        ),
        position_m: skeleton.joints[index].offset_m,
    };
    let frames = (0..60).map(|frame| (0..joints).map(|index| sample(frame, index)).collect());
    Clip {
        name: "chain".into(),
        frames: frames.collect(),
        skeleton: skeleton.clone(),
        frame_time_s: 1.0 / 30.0,
    }
}

#[test]
fn a_chain_of_256_joints_is_searched_and_one_of_257_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    bvh::write(&folder.path().join("a.bvh"), &chain(256), 0.01).expect("a clip");
    for metric in ["positions", "line"] {
        let arguments = [
            "clip",
            "find",
            "a.bvh",
            "--like",
            "a.bvh@20",
            "--check",
            "--apart-s",
            "0.2",
            "--metric",
            metric,
        ];
        let (found, told) = json(folder.path(), &arguments);
        assert!(told.contains("checked: the same moments"), "{told}");
        // All joints swing once in 30 frames.
        assert_eq!(found["moments"][0]["frame"], 50, "{found}");
    }
    bvh::write(&folder.path().join("a.bvh"), &chain(257), 0.01).expect("a clip");
    let blend = [
        "clip",
        "blend",
        "a.bvh@15",
        "a.bvh@40",
        "--output",
        "b.bvh",
        "--blend-s",
        "0.2",
        "--alone-s",
        "0",
    ];
    for arguments in [&["clip", "find", "a.bvh", "--like", "a.bvh@20"][..], &blend] {
        let refused = sinew_in(folder.path(), arguments);
        let told = text(&refused.stderr);
        assert_eq!(refused.status.code(), Some(2), "{told}");
        assert!(told.contains("a.bvh: expected at most 256 joints that move, found 257"), "{told}");
    }
    assert!(!folder.path().join("b.bvh").exists());
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn a_face_of_163_joints_is_searched_and_blended() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set");
    let face = Path::new(&data).join("foreign/bvh/makehuman_face.bvh").display().to_string();
    let like = format!("{face}@20");
    for metric in ["positions", "line"] {
        let (found, told) = json(
            folder.path(),
            &["clip", "find", &face, "--like", &like, "--check", "--metric", metric],
        );
        assert!(told.contains("checked: the same moments"), "{told}");
        assert!(found["moments"].as_array().is_some_and(|moments| !moments.is_empty()), "{found}");
    }
    let (from, to) = (format!("{face}@20"), format!("{face}@40"));
    let (blended, _) = json(
        folder.path(),
        &["clip", "blend", &from, &to, "--output", "face.bvh", "--blend-s", "0.3"],
    );
    assert_eq!(blended["not_converged"], 0, "{blended}");
}
