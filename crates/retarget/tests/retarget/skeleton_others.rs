//! Skeletons that are not complete humans: found parts, missing parts with reasons, and no confident wrong answers.

use glam::DVec3;
use proptest::prelude::*;
use sinew_mocap::{Skeleton, SkeletonJoint};
use sinew_retarget::skeleton::{FigureMappingError, MapHead, SkeletonMatch, figure_mapping};
use sinew_retarget::{Landmark, Side};

/// Name of a joint, name of its parent, and its position.
type Row = (&'static str, &'static str, [f64; 3]);

/// Creates a skeleton. A row with `*name` becomes a joint on each side, `LeftName` and `RightName`, mirrored along
/// x.
fn skeleton(rows: &[Row]) -> Skeleton {
    let mut joints: Vec<SkeletonJoint> = Vec::new();
    let mut places: Vec<DVec3> = Vec::new();
    for (name, parent, place) in rows {
        let sides: &[(&str, f64)] =
            if name.contains('*') { &[("Left", 1.0), ("Right", -1.0)] } else { &[("", 1.0)] };
        for (side, sign) in sides {
            let parent = parent.replace('*', side);
            let parent = joints.iter().position(|joint| joint.name == parent);
            assert_eq!(parent.is_none(), joints.is_empty(), "{name}");
            let place = DVec3::new(sign * place[0], place[1], place[2]);
            let offset_m = parent.map_or(place, |parent| place - places[parent]);
            places.push(place);
            joints.push(SkeletonJoint {
                name: name.replace('*', side),
                parent,
                offset_m,
                end_sites_m: Vec::new(),
            });
        }
    }
    Skeleton { joints }
}

fn nameless(mut skeleton: Skeleton) -> Skeleton {
    for (place, joint) in skeleton.joints.iter_mut().enumerate() {
        joint.name = format!("joint_{place}");
    }
    skeleton
}

/// A dog, standing along z, with a human's names.
const DOG: [Row; 16] = [
    ("Hips", "", [0.0, 0.5, 0.0]),
    ("Spine", "Hips", [0.0, 0.5, 0.15]),
    ("Spine1", "Spine", [0.0, 0.5, 0.35]),
    ("Neck", "Spine1", [0.0, 0.55, 0.5]),
    ("Head", "Neck", [0.0, 0.65, 0.6]),
    ("*Shoulder", "Spine1", [0.05, 0.5, 0.42]),
    ("*Arm", "*Shoulder", [0.08, 0.42, 0.42]),
    ("*ForeArm", "*Arm", [0.08, 0.25, 0.4]),
    ("*Hand", "*ForeArm", [0.08, 0.07, 0.4]),
    ("*HandEnd", "*Hand", [0.08, 0.0, 0.43]),
    ("*UpLeg", "Hips", [0.07, 0.45, 0.0]),
    ("*Leg", "*UpLeg", [0.07, 0.27, 0.05]),
    ("*Foot", "*Leg", [0.07, 0.1, -0.02]),
    ("*FootEnd", "*Foot", [0.07, 0.0, 0.02]),
    ("Tail", "Hips", [0.0, 0.5, -0.1]),
    ("Tail1", "Tail", [0.0, 0.45, -0.25]),
];

const HORSE: [Row; 14] = [
    ("pelvis", "", [0.0, 1.5, 0.0]),
    ("spine", "pelvis", [0.0, 1.5, 0.5]),
    ("withers", "spine", [0.0, 1.55, 1.0]),
    ("neck", "withers", [0.0, 1.8, 1.3]),
    ("head", "neck", [0.0, 2.1, 1.6]),
    ("*_front_upleg", "withers", [0.15, 1.2, 1.0]),
    ("*_front_leg", "*_front_upleg", [0.15, 0.9, 0.95]),
    ("*_front_foot", "*_front_leg", [0.15, 0.4, 1.0]),
    ("*_front_hoof", "*_front_foot", [0.15, 0.05, 1.0]),
    ("*_hind_thigh", "pelvis", [0.15, 1.3, 0.0]),
    ("*_hind_shin", "*_hind_thigh", [0.15, 0.9, 0.1]),
    ("*_hind_foot", "*_hind_shin", [0.15, 0.5, -0.05]),
    ("*_hind_hoof", "*_hind_foot", [0.15, 0.05, 0.0]),
    ("tail", "pelvis", [0.0, 1.4, -0.2]),
];

const FACE: [Row; 9] = [
    ("neck", "", [0.0, 0.0, 0.0]),
    ("head", "neck", [0.0, 0.1, 0.0]),
    ("jaw", "head", [0.0, 0.12, 0.05]),
    ("*_brow_inner", "head", [0.02, 0.2, 0.1]),
    ("*_brow_outer", "head", [0.04, 0.2, 0.09]),
    ("*_eye", "head", [0.03, 0.18, 0.08]),
    ("*_lip_corner", "jaw", [0.02, 0.1, 0.1]),
    ("tongue_01", "jaw", [0.0, 0.11, 0.06]),
    ("tongue_02", "tongue_01", [0.0, 0.11, 0.08]),
];

const HAND: [Row; 8] = [
    ("LeftHand", "", [0.0, 0.0, 0.0]),
    ("LeftHandThumb1", "LeftHand", [0.03, 0.0, 0.02]),
    ("LeftHandThumb2", "LeftHandThumb1", [0.05, 0.0, 0.04]),
    ("LeftHandIndex1", "LeftHand", [0.09, 0.0, 0.02]),
    ("LeftHandIndex2", "LeftHandIndex1", [0.13, 0.0, 0.02]),
    ("LeftHandIndex3", "LeftHandIndex2", [0.15, 0.0, 0.02]),
    ("LeftHandPinky1", "LeftHand", [0.08, 0.0, -0.02]),
    ("LeftHandPinky2", "LeftHandPinky1", [0.11, 0.0, -0.02]),
];

const SPIDER: [Row; 9] = [
    ("body", "", [0.0, 0.2, 0.0]),
    ("*a1", "body", [0.1, 0.2, 0.1]),
    ("*a2", "*a1", [0.3, 0.4, 0.2]),
    ("*a3", "*a2", [0.5, 0.0, 0.3]),
    ("*b1", "body", [0.1, 0.2, -0.1]),
    ("*b2", "*b1", [0.3, 0.4, -0.2]),
    ("*b3", "*b2", [0.5, 0.0, -0.3]),
    ("abdomen", "body", [0.0, 0.2, -0.2]),
    ("fangs", "body", [0.0, 0.2, 0.15]),
];

const UPPER_BODY: [Row; 7] = [
    ("Spine", "", [0.0, 1.1, 0.0]),
    ("Chest", "Spine", [0.0, 1.3, 0.0]),
    ("Neck", "Chest", [0.0, 1.5, 0.0]),
    ("Head", "Neck", [0.0, 1.6, 0.0]),
    ("*Arm", "Chest", [0.17, 1.45, 0.0]),
    ("*ForeArm", "*Arm", [0.47, 1.45, 0.0]),
    ("*Hand", "*ForeArm", [0.73, 1.45, 0.0]),
];

const ARM: [Row; 4] = [
    ("Chest", "", [0.0, 1.3, 0.0]),
    ("RightArm", "Chest", [-0.17, 1.45, 0.0]),
    ("RightForeArm", "RightArm", [-0.47, 1.45, 0.0]),
    ("RightHand", "RightForeArm", [-0.73, 1.45, 0.0]),
];

#[test]
fn an_animal_is_told_and_never_sure() {
    for (rows, says) in [(DOG.as_slice(), "animal"), (HORSE.as_slice(), "animal")] {
        for skeleton in [skeleton(rows), nameless(skeleton(rows))] {
            let matched = SkeletonMatch::new(&skeleton, &[]);
            for (landmark, found) in matched.found() {
                assert!(
                    found.confidence <= 0.4 && found.reason.contains(says),
                    "{}: {found:?}",
                    landmark.name()
                );
            }
            let nothing = matched.found().count() == 0;
            assert!(
                nothing || matched.findings.iter().any(|finding| finding.contains(says)),
                "{:?}",
                matched.findings
            );
        }
    }
}

#[test]
fn what_is_no_body_has_no_limbs() {
    for rows in [FACE.as_slice(), HAND.as_slice(), SPIDER.as_slice()] {
        for skeleton in [skeleton(rows), nameless(skeleton(rows))] {
            let matched = SkeletonMatch::new(&skeleton, &[]);
            let limbs: Vec<_> =
                matched.found().filter(|(landmark, _)| landmark.side().is_some()).collect();
            assert!(limbs.is_empty(), "{limbs:?}");
            assert!(matched.missing().all(|(_, reason)| !reason.is_empty()));
            assert!(matched.unit.is_none() && matched.joint(Landmark::Pelvis).is_none());
            let head = MapHead { name: "none", metres_per_unit: 1.0, rate_hz: None };
            let error = figure_mapping(&skeleton, &matched, head).unwrap_err();
            assert!(error.to_string().contains("l_hip ("), "{error}");
        }
    }
    let face = skeleton(&FACE);
    let matched = SkeletonMatch::new(&face, &[]);
    let head = matched.joint(Landmark::Head).map(|joint| face.joints[joint].name.as_str());
    assert_eq!(head, Some("head"));
}

#[test]
fn a_part_of_a_body_is_matched_as_far_as_it_goes() {
    let upper = skeleton(&UPPER_BODY);
    let matched = SkeletonMatch::new(&upper, &[]);
    let name = |landmark| matched.joint(landmark).map(|joint| upper.joints[joint].name.as_str());
    assert_eq!(name(Landmark::Elbow(Side::Right)), Some("RightForeArm"));
    assert_eq!(name(Landmark::Chest), Some("Chest"));
    assert_eq!(name(Landmark::Head), Some("Head"));
    let head = MapHead { name: "upper", metres_per_unit: 1.0, rate_hz: None };
    let FigureMappingError::Missing(missing) = figure_mapping(&upper, &matched, head).unwrap_err()
    else {
        panic!()
    };
    assert_eq!(missing.len(), 7, "pelvis, hips, knees, ankles: {missing:?}");

    let arm = skeleton(&ARM);
    let matched = SkeletonMatch::new(&arm, &[]);
    assert_eq!(matched.joint(Landmark::Wrist(Side::Right)), Some(3));
    assert_eq!(matched.joint(Landmark::Wrist(Side::Left)), None);
    let reason = &matched.get(Landmark::Wrist(Side::Right)).expect("a wrist").reason;
    assert_eq!(reason, "the other side has no such limb");
}

#[test]
fn nothing_is_found_in_nothing() {
    let matched = SkeletonMatch::new(&Skeleton { joints: Vec::new() }, &[]);
    assert_eq!((matched.found().count(), matched.missing().count()), (0, 18));
    let matched = SkeletonMatch::new(&skeleton(&[("Hips", "", [0.0, 1.0, 0.0])]), &[]);
    assert!(matched.missing().count() >= 17);
}

/// The maximum that a reader accepts: two chains and a star.
#[test]
fn large_trees_take_no_time() {
    let tree = |parent: fn(usize) -> usize| {
        let joints = (0..1024).map(|joint: usize| SkeletonJoint {
            name: format!("{}{joint}", ["LeftArm", "RightLeg", "x"][joint % 3]),
            parent: joint.checked_sub(1).map(|_| parent(joint)),
            offset_m: DVec3::new(0.1, 1.0, 0.0),
            end_sites_m: Vec::new(),
        });
        Skeleton { joints: joints.collect() }
    };
    let start = std::time::Instant::now();
    for skeleton in [tree(|joint| joint.saturating_sub(2)), tree(|_| 0), tree(|joint| joint - 1)] {
        SkeletonMatch::new(&skeleton, &[]);
    }
    // The test took 0.2 s on its author's machine.
    assert!(start.elapsed().as_secs() < 20, "{:?}", start.elapsed());
}

/// The fox of Khronos' samples: human names, and offsets that mean nothing without its poses.
#[test]
fn a_fox_without_poses_is_no_human() {
    let mut fox = skeleton(&[
        ("b_Hip_01", "", [0.0, 26.0, -30.0]),
        ("b_Spine01_02", "b_Hip_01", [0.0, 40.0, -30.0]),
        ("b_Spine02_03", "b_Spine01_02", [0.0, 60.0, -30.0]),
        ("b_Neck_04", "b_Spine02_03", [0.0, 75.0, -30.0]),
        ("b_Head_05", "b_Neck_04", [0.0, 90.0, -30.0]),
        ("b_*UpperArm_09", "b_Spine02_03", [6.0, 70.0, -30.0]),
        ("b_*ForeArm_010", "b_*UpperArm_09", [6.0, 85.0, -30.0]),
        ("b_*Hand_011", "b_*ForeArm_010", [6.0, 97.0, -30.0]),
        ("b_Tail01_012", "b_Hip_01", [0.0, 26.0, -45.0]),
        ("b_*Leg01_015", "b_Hip_01", [6.0, 30.0, -30.0]),
        ("b_*Leg02_016", "b_*Leg01_015", [6.0, 42.0, -30.0]),
        ("b_*Foot01_017", "b_*Leg02_016", [6.0, 56.0, -30.0]),
    ]);
    fox.joints[0].offset_m = DVec3::ZERO;
    let matched = SkeletonMatch::new(&fox, &[]);
    assert!(
        matched.found().count() > 10
            && matched.findings.iter().any(|finding| finding.contains("animal"))
    );
    assert!(matched.found().all(|(_, found)| found.confidence <= 0.4));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    /// Any tree with any names gets an answer for each landmark, with a confidence within its bounds.
    #[test]
    fn any_tree_gets_an_answer(
        rows in prop::collection::vec(
            (
                prop::sample::select(vec![
                    "Hips", "LeftUpLeg", "RightUpLeg", "LeftLeg", "RightLeg", "LeftFoot", "RightFoot", "Spine", "Neck",
                    "Head", "LeftArm", "LeftForeArm", "LeftHand", "RightArm", "RightForeArm", "RightHand", "twist", "x",
                ]),
                any::<prop::sample::Index>(),
                prop::array::uniform3(-1.0..1.0_f64),
            ),
            1..40,
        ),
        scale in prop::sample::select(vec![0.0, 1e-9, 1.0, 1e9]),
    ) {
        let joints: Vec<SkeletonJoint> = rows
            .iter()
            .enumerate()
            .map(|(place, (name, parent, offset))| SkeletonJoint {
                name: (*name).to_owned(),
                parent: (place > 0).then(|| parent.index(place)),
                offset_m: scale * DVec3::from(*offset),
                end_sites_m: Vec::new(),
            })
            .collect();
        let skeleton = Skeleton { joints };
        let matched = SkeletonMatch::new(&skeleton, &[]);
        prop_assert_eq!(matched.found().count() + matched.missing().count(), 18);
        for (landmark, found) in matched.found() {
            prop_assert!((0.0..=1.0).contains(&found.confidence), "{}: {:?}", landmark.name(), found);
            prop_assert!(found.joint < skeleton.joints.len() && !found.reason.is_empty());
        }
        let head = MapHead { name: "any", metres_per_unit: 1.0, rate_hz: None };
        if let Ok(proposed) = figure_mapping(&skeleton, &matched, head) {
            let read: sinew_mocap::SkeletonMap = toml::from_str(&proposed.to_toml()).expect("it reads back");
            prop_assert_eq!(read, proposed.map);
        }
    }
}

/// A robot's arm has names of bones but is not a person: its unit remains unknown.
#[test]
fn a_lone_arm_tells_no_height() {
    let arm = skeleton(&[
        ("base", "", [0.0, 0.0, 0.0]),
        ("shoulder", "base", [0.0, 0.06, 0.0]),
        ("elbow", "shoulder", [0.0, 0.18, 0.0]),
        ("wrist", "elbow", [0.1, 0.18, 0.0]),
        ("gripper", "wrist", [0.2, 0.18, 0.0]),
    ]);
    assert_eq!(SkeletonMatch::new(&arm, &[]).unit, None);
    // Two arms on one trunk belong to an upper body.
    let two = skeleton(&[
        ("chest", "", [0.0, 0.0, 0.0]),
        ("*Shoulder", "chest", [0.2, 0.2, 0.0]),
        ("*Elbow", "*Shoulder", [0.5, 0.2, 0.0]),
        ("*Wrist", "*Elbow", [0.75, 0.2, 0.0]),
    ]);
    assert!(SkeletonMatch::new(&two, &[]).unit.is_some());
}
