//! Shapes of the face of `sinew rig new --face`: 15 visemes and the 52 names of `ARKit`, as poses of its joints.

use crate::description::FaceShape;

/// Angle of the jaw in each viseme, deg. The face has no lips, tongue and teeth.
const VISEMES: [(&str, f64); 15] = [
    ("sil", 0.0),
    ("PP", 0.0),
    ("FF", -3.0),
    ("TH", -6.0),
    ("DD", -6.0),
    ("kk", -8.0),
    ("CH", -5.0),
    ("SS", -3.0),
    ("nn", -5.0),
    ("RR", -6.0),
    ("aa", -22.0),
    ("E", -14.0),
    ("ih", -9.0),
    ("oh", -16.0),
    ("ou", -8.0),
];

/// A pose: names of joints without the side, and angles, deg.
type Pose = &'static [(&'static str, f64)];

/// Shapes that exist for both sides, without `Left` and `Right`. Angles are those of the left side; `eye_turn` and
/// `brow` have the opposite sign on the right side.
const SIDES: [(&str, Pose); 18] = [
    ("eyeBlink", &[("lid_upper", -8.0), ("lid_lower", -10.0)]),
    ("eyeLookDown", &[("eye_nod", -20.0), ("lid_upper", 14.0)]),
    ("eyeLookIn", &[("eye_turn", -28.0)]),
    ("eyeLookOut", &[("eye_turn", 28.0)]),
    ("eyeLookUp", &[("eye_nod", 20.0), ("lid_upper", 38.0)]),
    ("eyeSquint", &[("lid_upper", 22.0), ("lid_lower", -14.0)]),
    ("eyeWide", &[("lid_upper", 40.0), ("lid_lower", -33.0)]),
    ("mouthSmile", &[]),
    ("mouthFrown", &[]),
    ("mouthDimple", &[]),
    ("mouthStretch", &[]),
    ("mouthPress", &[]),
    ("mouthLowerDown", &[("jaw", -3.0)]),
    ("mouthUpperUp", &[]),
    // On the left side, a negative angle moves the inner end of the brow down.
    ("browDown", &[("brow", -15.0)]),
    ("browOuterUp", &[("brow", -10.0)]),
    ("cheekSquint", &[("lid_lower", -18.0)]),
    ("noseSneer", &[]),
];

/// Shapes without a side. Angles are those of the joints on the left side.
const MIDDLE: [(&str, Pose); 16] = [
    ("jawForward", &[]),
    ("jawLeft", &[]),
    ("jawRight", &[]),
    ("jawOpen", &[("jaw", -22.0)]),
    ("mouthClose", &[]),
    ("mouthFunnel", &[("jaw", -5.0)]),
    ("mouthPucker", &[("jaw", -2.0)]),
    ("mouthLeft", &[]),
    ("mouthRight", &[]),
    ("mouthRollLower", &[]),
    ("mouthRollUpper", &[]),
    ("mouthShrugLower", &[]),
    ("mouthShrugUpper", &[]),
    ("browInnerUp", &[("brow", 12.0)]),
    ("cheekPuff", &[]),
    ("tongueOut", &[("jaw", -8.0)]),
];

/// Returns all shapes of the face.
pub(super) fn shapes() -> Vec<FaceShape> {
    let shape = |name: String, pose: Vec<(String, f64)>| FaceShape { name, pose };
    let visemes = VISEMES.map(|(name, jaw_deg)| {
        shape(name.to_owned(), vec![("jaw".to_owned(), jaw_deg.to_radians())])
    });
    let sides = SIDES.iter().flat_map(|(name, pose)| {
        ["left", "right"].map(|side| {
            let capital = if side == "left" { "Left" } else { "Right" };
            shape(format!("{name}{capital}"), on(pose, &[side]))
        })
    });
    let middle =
        MIDDLE.iter().map(|(name, pose)| shape((*name).to_owned(), on(pose, &["left", "right"])));
    visemes.into_iter().chain(sides).chain(middle).collect()
}

/// Returns a pose with the joints of the given sides.
fn on(pose: Pose, sides: &[&str]) -> Vec<(String, f64)> {
    let mut joints = Vec::new();
    for (part, degrees) in pose {
        if *part == "jaw" {
            joints.push(("jaw".to_owned(), degrees.to_radians()));
            continue;
        }
        for side in sides {
            let mirrored = *side == "right" && ["eye_turn", "brow"].contains(part);
            let degrees = if mirrored { -degrees } else { *degrees };
            joints.push((format!("{part}_{side}"), degrees.to_radians()));
        }
    }
    joints
}
