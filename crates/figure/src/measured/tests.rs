use glam::{DQuat, DVec3};
use sinew_mocap::{JointSample, Recording, Skeleton, SkeletonJoint};

use super::*;
use crate::mapping;

/// Returns a person of `height` units in a file whose joints have Mixamo's names. `up` points up in the pose at
/// rest.
fn person(height: f64, up: DVec3) -> Recording {
    let turn = sinew_mocap::to_y(up).inverse();
    // Offsets as shares of the stature.
    let rows = [
        ("Hips", None, [0.0, 0.0, 0.0]),
        ("Spine", Some(0), [0.0, 0.1, 0.0]),
        ("Neck", Some(1), [0.0, 0.2, 0.0]),
        ("Head", Some(2), [0.0, 0.05, 0.0]),
        ("LeftUpLeg", Some(0), [0.05, -0.02, 0.0]),
        ("LeftLeg", Some(4), [0.0, -0.245, 0.0]),
        ("LeftFoot", Some(5), [0.0, -0.246, 0.0]),
        ("RightUpLeg", Some(0), [-0.05, -0.02, 0.0]),
        ("RightLeg", Some(7), [0.0, -0.245, 0.0]),
        ("RightFoot", Some(8), [0.0, -0.246, 0.0]),
        ("LeftArm", Some(1), [0.12, 0.18, 0.0]),
        ("LeftForeArm", Some(10), [0.186, 0.0, 0.0]),
        ("LeftHand", Some(11), [0.146, 0.0, 0.0]),
        ("RightArm", Some(1), [-0.12, 0.18, 0.0]),
        ("RightForeArm", Some(13), [-0.186, 0.0, 0.0]),
        ("RightHand", Some(14), [-0.146, 0.0, 0.0]),
    ];
    let joints = rows.map(|(name, parent, offset)| SkeletonJoint {
        name: name.to_owned(),
        parent,
        offset_m: turn * (height * DVec3::from(offset)),
        end_sites_m: Vec::new(),
    });
    Recording {
        name: "person".to_owned(),
        skeleton: Skeleton { joints: joints.into() },
        frames: Vec::new(),
        frame_time_s: Some(0.01),
        metres_per_unit: None,
        notes: Vec::new(),
    }
}

/// Adds frames in which the root is at a place, with a rotation.
fn with_root(mut recording: Recording, place: DVec3, turn: DQuat) -> Recording {
    let sample = |joint: &SkeletonJoint| {
        let root = joint.parent.is_none();
        Some(JointSample {
            rotation: if root { turn } else { DQuat::IDENTITY },
            position_m: if root { place } else { joint.offset_m },
        })
    };
    let frame: Vec<_> = recording.skeleton.joints.iter().map(sample).collect();
    recording.frames = vec![frame; 3];
    recording
}

fn measured(recording: &Recording, units: UnitOverrides) -> Measured {
    Measured::new(recording, &SkeletonMatch::of_recording(recording), None, units)
}

#[test]
fn the_unit_is_guessed_from_the_height_and_else_asked_for() {
    for (height, unit) in [(1.7, 1.0), (170.0, 0.01), (1700.0, 0.001), (67.0, 0.0254), (17.0, 0.1)]
    {
        let measured = measured(&person(height, DVec3::Y), UnitOverrides::default());
        assert_eq!(measured.metres_per_unit, Some(unit), "{measured}");
        assert!((1.5..1.9).contains(&measured.height_m().unwrap()), "{measured}");
        assert!(measured.warnings().is_empty(), "{measured}");
    }
    // 0.07 is a body of 7 cm in metres; 40 can be inches or CMU's unit.
    for height in [0.07, 40.0] {
        let measured = measured(&person(height, DVec3::Y), UnitOverrides::default());
        let refused = measured.unit().unwrap_err();
        assert!(refused.ends_with("; give it with --metres-per-unit"), "{refused}");
    }
    let units = UnitOverrides { metres_per_unit: Some(1.0), up: None };
    let small = measured(&person(0.07, DVec3::Y), units);
    assert!(small.warnings()[0].contains("0.5 to 2.5 m is believable"), "{:?}", small.warnings());
}

#[test]
fn a_known_skeleton_in_another_unit_is_noticed() {
    let m21 = mapping::known_skeletons().iter().find(|known| known.mapping.name == "m21").unwrap();
    let unit = |height, is_given| {
        let recording = person(height, DVec3::Y);
        let matched = SkeletonMatch::of_recording(&recording);
        let by = MappingSource { mapping: &m21.mapping, is_given };
        Measured::new(&recording, &matched, Some(by), UnitOverrides::default()).metres_per_unit
    };
    assert_eq!(unit(170.0, false), Some(0.01));
    // 67 units would be a body of 0.67 m in centimetres, but are a person in inches.
    assert_eq!(unit(67.0, false), Some(0.0254));
    assert_eq!(unit(1.7, false), Some(1.0));
    // A small body that no other unit explains: the skeleton's own unit decides among several.
    assert_eq!(unit(90.0, false), Some(0.01));
    assert_eq!(unit(67.0, true), Some(0.01), "the user's word");
}

#[test]
fn z_is_up_where_the_body_stands_along_it() {
    let up = |recording: &Recording| measured(recording, UnitOverrides::default()).up;
    let at = |place| with_root(person(1.7, DVec3::Z), place, DQuat::IDENTITY);
    for recording in [person(1.7, DVec3::Z), at(DVec3::new(3.0, 2.0, 0.92))] {
        let up = up(&recording);
        assert_eq!(
            (up.axis, up.rest, up.doubt.clone()),
            (DVec3::Z, DVec3::Z, None),
            "{}",
            up.reason
        );
    }
    // In the rest pose y is up. In the world z is up, since the root is rotated.
    let turned = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2);
    let standing = with_root(person(1.7, DVec3::Y), DVec3::new(3.0, 2.0, 0.9), turned);
    let found = up(&standing);
    assert_eq!((found.axis, found.rest), (DVec3::Z, DVec3::Y), "{}", found.reason);
    let upright = measured(&standing, UnitOverrides::default()).apply(standing).unwrap();
    let root = upright.frames[0][0].unwrap();
    assert!((root.rotation * DVec3::Y).distance(DVec3::Y) < 1e-12);
    assert!((root.position_m.y - 0.9).abs() < 1e-12);
    // A body that lies on the floor does not stand on a floor across the axis.
    let lying = with_root(person(1.7, DVec3::Y), DVec3::new(3.0, 0.1, 2.0), turned);
    let found = up(&lying);
    assert_eq!(found.axis, DVec3::Y, "{}", found.reason);
    assert!(found.doubt.unwrap().contains("from feet to head is along z"));
    let units = UnitOverrides { metres_per_unit: None, up: Some(Up::Z) };
    assert_eq!(measured(&lying, units).up.axis, DVec3::Z);
}
