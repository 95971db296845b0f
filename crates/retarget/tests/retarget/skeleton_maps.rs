//! Compares proposed maps onto the figure with the hand-written maps of host-sim, body by body, on recorded files.

use std::path::PathBuf;

use sinew_mocap::skeleton_map::End;
use sinew_mocap::{Clip, SkeletonMap, format, gaps};
use sinew_retarget::skeleton::{FigureMapping, MapHead, SkeletonMatch, figure_mapping};

/// A recorded file for each hand-written map.
const FILES: [(&str, &str); 11] = [
    ("asfamc", "cmu/fight/135_06.bvh"),
    // The first file again, with the names of the ASF.
    ("cmu_asf", "cmu/fight/135_06.bvh"),
    ("cgspeed_mb_asf", "cmu/broad-12hz/16_01.bvh"),
    ("bandai", "bandai/fight/dataset-1_slash_normal_001.bvh"),
    ("bandai", "bandai/broad-12hz/dataset-2_run_active_036.bvh"),
    ("cgspeed_daz", "cmu/fight/88_06.bvh"),
    ("cgspeed_mb", "cmu/fight/02_05.bvh"),
    ("cgspeed_mb", "cmu/walk/07_01.bvh"),
    ("deepmimic", "deepmimic/humanoid3d_walk.txt"),
    ("geno", "geno/Geno_stance.bvh"),
    ("m21", "cmu/fight/14_01.bvh"),
];

/// Differences in which both sides are correct: map, body, reason.
const BOTH_RIGHT: [(&str, &str, &str); 3] = [
    // The file's end site is the middle of a ball, 0.04 m beyond the wrist. The proposal assumes a human's hand.
    ("deepmimic", "hand_l", "the hand is a ball"),
    ("deepmimic", "hand_r", "the hand is a ball"),
    // The file ends at the head's joint. Its hand-written map has the head's length of the CMU skeletons from which
    // the file was made, which is not in the file; the proposal assumes a human's.
    ("m21", "head", "the end is a guess"),
];

/// CMU's names in the BVH files, and in the ASF from which they were made.
const ASF_NAMES: [(&str, &str); 31] = [
    ("Hips", "root"),
    ("LHipJoint", "lhipjoint"),
    ("LeftUpLeg", "lfemur"),
    ("LeftLeg", "ltibia"),
    ("LeftFoot", "lfoot"),
    ("LeftToeBase", "ltoes"),
    ("RHipJoint", "rhipjoint"),
    ("RightUpLeg", "rfemur"),
    ("RightLeg", "rtibia"),
    ("RightFoot", "rfoot"),
    ("RightToeBase", "rtoes"),
    ("LowerBack", "lowerback"),
    ("Spine", "upperback"),
    ("Spine1", "thorax"),
    ("Neck", "lowerneck"),
    ("Neck1", "upperneck"),
    ("Head", "head"),
    ("LeftShoulder", "lclavicle"),
    ("LeftArm", "lhumerus"),
    ("LeftForeArm", "lradius"),
    ("LeftHand", "lwrist"),
    ("LeftFingerBase", "lhand"),
    ("LeftHandIndex1", "lfingers"),
    ("LThumb", "lthumb"),
    ("RightShoulder", "rclavicle"),
    ("RightArm", "rhumerus"),
    ("RightForeArm", "rradius"),
    ("RightHand", "rwrist"),
    ("RightFingerBase", "rhand"),
    ("RightHandIndex1", "rfingers"),
    ("RThumb", "rthumb"),
];

#[test]
#[ignore = "needs SINEW_DATA"]
fn proposals_are_the_hand_written_maps() {
    let mut wrong = Vec::new();
    for (name, file) in FILES {
        let mut clip = clip(file);
        if name == "cmu_asf" {
            for joint in &mut clip.skeleton.joints {
                let renamed =
                    ASF_NAMES.iter().find(|(bvh, _)| *bvh == joint.name).expect("a joint of CMU's");
                renamed.1.clone_into(&mut joint.name);
            }
        }
        let hand_written = hand_written(name);
        let proposed = proposal(&clip, &hand_written);
        wrong.extend(differences(name, &hand_written, &proposed.map));
        assert!(
            hand_written.signature.matches(&clip.skeleton),
            "{file} is no longer known as {name}"
        );
        assert!(proposed.map.signature.matches(&clip.skeleton), "{file} is not known again");
        let read: SkeletonMap = toml::from_str(&proposed.to_toml()).expect(file);
        assert_eq!(read, proposed.map, "{file}");
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn clip(file: &str) -> Clip {
    let data: PathBuf = std::env::var_os("SINEW_DATA").expect("SINEW_DATA is set").into();
    let recording = format::read(&data.join(file)).expect(file);
    let frame_time_s = recording.frame_time_s.unwrap_or(1.0 / 120.0);
    gaps::fill(recording, frame_time_s, 1e6).expect(file).0
}

fn hand_written(name: &str) -> SkeletonMap {
    let file = format!("{}/../figure/mappings/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    toml::from_str(&std::fs::read_to_string(&file).expect(&file)).expect(&file)
}

fn proposal(clip: &Clip, beside: &SkeletonMap) -> FigureMapping {
    let matched = SkeletonMatch::of_clip(clip);
    let unit = matched.unit.as_ref().expect("legs tell a height").metres_per_unit;
    let unit = unit
        .unwrap_or_else(|| panic!("{}: no unit is believable: {:?}", beside.name, matched.unit));
    assert!((unit / beside.metres_per_unit - 1.0).abs() < 1e-4, "{}: {unit}", beside.name);
    let head = MapHead { name: &beside.name, metres_per_unit: unit, rate_hz: beside.rate_hz };
    figure_mapping(&clip.skeleton, &matched, head)
        .unwrap_or_else(|error| panic!("{}: {error}", beside.name))
}

fn differences(name: &str, hand_written: &SkeletonMap, proposed: &SkeletonMap) -> Vec<String> {
    assert!(hand_written.bodies.keys().eq(proposed.bodies.keys()));
    let mut wrong = Vec::new();
    for (body, right) in &hand_written.bodies {
        let ours = &proposed.bodies[body];
        if BOTH_RIGHT.iter().any(|(map, other, _)| (*map, *other) == (name, body)) {
            continue;
        }
        if (ours.origin != right.origin)
            || (ours.rotation != right.rotation)
            || !same_end(&ours.end, &right.end)
        {
            wrong.push(format!("{name}: {body}: expected {right:?}, proposed {ours:?}"));
        }
    }
    wrong
}

/// Returns whether two ends agree. Ends that are not in the file are estimates, and their lengths may differ by 25
/// %.
fn same_end(ours: &End, right: &End) -> bool {
    match (ours, right) {
        (End::Beyond { beyond: a, ratio: x }, End::Beyond { beyond: b, ratio: y }) => {
            a == b && (x / y - 1.0).abs() < 0.25
        }
        _ => ours == right,
    }
}
