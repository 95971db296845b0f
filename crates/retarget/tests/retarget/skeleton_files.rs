//! Landmarks of recorded files of many makers, with and without their names.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sinew_mocap::{Clip, bvh, format, gaps};
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_retarget::{Landmark, Side};

/// Words for left and right in a maker's names.
type Sides = (&'static str, &'static str);

/// A file; the joints of the middle and the left side, which a person found in its tree; up; and sides. The order of
/// the joints is pelvis, chest, neck, head, shoulder, elbow, wrist, hip, knee, ankle, toe; `-` if there is no joint.
type Expected = (&'static str, &'static str, char, Sides);

const FOREIGN: [Expected; 13] = [
    ("foreign/bvh/ad_fair1_dab.bvh", HIK_4, 'z', LEFT),
    ("foreign/bvh/ad_rokoko_jesse.bvh", HIK_3, 'y', LEFT),
    (
        "foreign/bvh/assimp_Boxing_Toes_short.bvh",
        "Hips Chest Neck Head LeftShoulder LeftElbow LeftWrist LeftHip LeftKnee LeftAnkle LeftToes",
        'y',
        LEFT,
    ),
    (
        "foreign/bvh/axisneuron_18.bvh",
        "Hips Spine3 Neck Head LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot -",
        'y',
        LEFT,
    ),
    ("foreign/bvh/fairmotion_pfnn.bvh", HIK_2, 'y', LEFT),
    (
        "foreign/bvh/makehuman_dance1.bvh",
        "Hips Spine3 Neck Head UpArm_L LoArm_L Hand_L UpLeg_L LoLeg_L Foot_L Toe_L",
        'z',
        ("_L", "_R"),
    ),
    (
        "foreign/bvh/makehuman_face.bvh",
        "root spine01 neck01 head upperarm01.L lowerarm01.L wrist.L upperleg01.L lowerleg01.L foot.L toe1-1.L",
        'z',
        (".L", ".R"),
    ),
    (
        "foreign/bvh/mocopi_jump.bvh",
        "root torso_7 neck_1 head l_up_arm l_low_arm l_hand l_up_leg l_low_leg l_foot l_toes",
        'y',
        ("l_", "r_"),
    ),
    (
        "foreign/bvh/olympe_root.bvh",
        "Hips Chest Neck Head LeftUpArm LeftLowArm LeftHand LeftUpLeg LeftLowLeg LeftFoot -",
        'y',
        LEFT,
    ),
    ("foreign/bvh/pybvh_test1.bvh", HIK_4, 'z', LEFT),
    (
        "foreign/bvh/pymo_meredith.bvh",
        "Hips Spine - Head LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase",
        'y',
        LEFT,
    ),
    (
        "foreign/bvh/sl_walk_male.bvh",
        "hip chest neck head lShldr lForeArm lHand lThigh lShin lFoot -",
        'y',
        ("l", "r"),
    ),
    (
        "foreign/amc/zump/walking.amc",
        "root UpperSpineJoint LowerNeckJoint UpperNeckJoint LeftShoulderJoint LeftElbowJoint \
         LeftWristJoint LeftHipJoint LeftKneeJoint LeftAnkleJoint LeftToesJoint",
        'y',
        LEFT,
    ),
];

const LEFT: Sides = ("Left", "Right");
/// Names of `MotionBuilder`, with this number of spine joints after the first.
const HIK_2: &str =
    "Hips Spine1 Neck Head LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase";
const HIK_3: &str =
    "Hips Spine2 Neck Head LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase";
const HIK_4: &str =
    "Hips Spine3 Neck Head LeftArm LeftForeArm LeftHand LeftUpLeg LeftLeg LeftFoot LeftToeBase";

fn landmarks(expected: &str, sides: Sides) -> BTreeMap<Landmark, String> {
    let of = |side| {
        [
            Landmark::Pelvis,
            Landmark::Chest,
            Landmark::Neck,
            Landmark::Head,
            Landmark::Shoulder(side),
            Landmark::Elbow(side),
            Landmark::Wrist(side),
            Landmark::Hip(side),
            Landmark::Knee(side),
            Landmark::Ankle(side),
            Landmark::Toe(side),
        ]
    };
    let mut landmarks = BTreeMap::new();
    for (side, from, to) in [(Side::Left, sides.0, sides.0), (Side::Right, sides.0, sides.1)] {
        for (landmark, name) in
            of(side).into_iter().zip(expected.split(' ')).filter(|(_, name)| *name != "-")
        {
            let name = if landmark.side().is_some() {
                name.replacen(from, to, 1)
            } else {
                name.to_owned()
            };
            landmarks.insert(landmark, name);
        }
    }
    landmarks
}

fn data() -> PathBuf {
    std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set").into()
}

fn clip(file: &Path) -> Clip {
    let recording = format::read(file).unwrap_or_else(|_| without_last_row(file));
    let frame_time_s = recording.frame_time_s.unwrap_or(1.0 / 120.0);
    gaps::fill(recording, frame_time_s, 1e6)
        .unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .0
}

/// Reads a file that has one row more than it declares.
fn without_last_row(file: &Path) -> sinew_mocap::Recording {
    let text = std::fs::read_to_string(file).expect("text");
    let (text, _) = text.trim_end().rsplit_once('\n').expect("rows");
    bvh::parse(text.as_bytes(), file).expect("a motion")
}

fn found(clip: &Clip) -> (SkeletonMatch, BTreeMap<Landmark, String>) {
    let matched = SkeletonMatch::of_clip(clip);
    let found = matched
        .found()
        .map(|(l, found)| (l, clip.skeleton.joints[found.joint].name.clone()))
        .collect();
    (matched, found)
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn files_of_many_makers() {
    for (file, expected, up, sides) in &FOREIGN {
        let (matched, found) = found(&clip(&data().join(file)));
        assert_eq!(found, landmarks(expected, *sides), "{file}");
        let lowest = matched.lowest().expect("some");
        assert!(lowest.1.confidence > 0.75, "{file}: {lowest:?}");
        let axis = matched.up.expect(file).axis;
        assert_eq!(axis, if *up == 'y' { glam::DVec3::Y } else { glam::DVec3::Z }, "{file}");
        assert_eq!(matched.findings, Vec::<String>::new(), "{file}");
    }
    // 45 units tall: a child in inches, and impossible in centimetres or metres.
    let unit = SkeletonMatch::of_clip(&clip(&data().join("foreign/bvh/ad_fair1_dab.bvh")))
        .unit
        .expect("legs");
    assert_eq!(unit.metres_per_unit, Some(0.0254), "{unit:?}");
}

#[test]
#[ignore = "needs SINEW_DATA"]
fn no_body_where_there_is_none() {
    let (matched, found) = found(&clip(&data().join("foreign/bvh/bvhanim_simple.bvh")));
    assert_eq!(found, BTreeMap::new());
    assert!(matched.missing().all(|(_, reason)| !reason.is_empty()) && matched.unit.is_none());
}

/// Every file of CMU and Bandai, with the skeleton that its index names.
#[test]
#[ignore = "needs SINEW_DATA"]
fn every_file_of_the_data() {
    let daz = "hip chest neck head lShldr lForeArm lHand lThigh lShin lFoot -";
    let asf = "hip thorax lowerneck head lhumerus lradius lwrist lfemur ltibia lfoot ltoes";
    let m21 = HIK_2.replace("Neck", "Neck1");
    let bandai =
        "Hips Chest Neck Head UpperArm_L LowerArm_L Hand_L UpperLeg_L LowerLeg_L Foot_L Toes_L";
    let kinds = [
        (HIK_2, LEFT, "LHipJoint", 0.0254 / 0.45),
        (daz, ("l", "r"), "lButtock", 0.01),
        (asf, ("l", "r"), "lhipjoint", 0.0254 / 0.45),
        (bandai, ("_L", "_R"), "joint_Root", 0.01),
        (&m21, LEFT, "Neck1", 0.01),
    ];
    let mut count = 0;
    for folder in [
        "cmu/fight",
        "cmu/walk",
        "cmu/run",
        "cmu/broad-12hz",
        "bandai/fight",
        "bandai/run",
        "bandai/walk",
        "bandai/broad-12hz",
    ] {
        for entry in std::fs::read_dir(data().join(folder)).expect(folder) {
            let file = entry.expect(folder).path();
            if file.extension().is_none_or(|extension| extension != "bvh") {
                continue;
            }
            let clip = clip(&file);
            let known = kinds.iter().find(|(_, _, joint, _)| clip.skeleton.find(joint).is_some());
            let (expected, sides, _, unit) = known.expect("a known skeleton");
            let (matched, found) = found(&clip);
            assert_eq!(found, landmarks(expected, *sides), "{}", file.display());
            assert_eq!(matched.findings, Vec::<String>::new(), "{}", file.display());
            assert_eq!(matched.up.expect("up").axis, glam::DVec3::Y, "{}", file.display());
            let guess = matched.unit.expect("legs");
            assert_eq!(guess.metres_per_unit, Some(*unit), "{}: {}", file.display(), guess.reason);
            count += 1;
        }
    }
    assert!(count >= 816, "{count} files");
}

/// Tests all files again, with names that have no meaning.
#[test]
#[ignore = "needs SINEW_DATA"]
fn without_names_the_tree_and_the_motion_tell() {
    let (mut right, mut all) = (0, 0);
    let mut lines = Vec::new();
    for (file, expected, _, sides) in &FOREIGN {
        let mut clip = clip(&data().join(file));
        let expected = landmarks(expected, *sides);
        let expected: BTreeMap<Landmark, usize> =
            expected.iter().map(|(l, name)| (*l, clip.skeleton.find(name).expect(file))).collect();
        for (place, joint) in clip.skeleton.joints.iter_mut().enumerate() {
            joint.name = format!("joint_{place}");
        }
        let matched = SkeletonMatch::of_clip(&clip);
        let missed: Vec<_> = expected
            .iter()
            .filter(|(l, joint)| matched.joint(**l) != Some(**joint))
            .map(|(l, _)| l.name())
            .collect();
        right += expected.len() - missed.len();
        all += expected.len();
        lines.push(format!(
            "{file}: {} of {}, not {missed:?}",
            expected.len() - missed.len(),
            expected.len()
        ));
        assert!(matched.found().all(|(_, found)| found.confidence < 0.75), "{file}");
    }
    println!("{}\nwithout names: {right} of {all}", lines.join("\n"));
    assert!(10 * right >= 8 * all, "{}", lines.join("\n"));
}
