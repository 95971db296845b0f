//! Who or what wrote a file, where it shows it: by what it says of itself, or by names that only one program gives.

use std::path::Path;

use sinew_mocap::Skeleton;

/// Programs by joints that all of their files have, and others have not.
const BY_NAMES: [(&[&str], &str); 7] = [
    (&["Hips", "Chest4", "LeftCollar"], "Xsens MVN"),
    (&["Hips", "Spine3", "LeftInHandIndex"], "Axis Neuron (Perception Neuron)"),
    (&["root", "torso_7", "neck_2", "l_low_leg"], "mocopi"),
    (&["hip", "abdomen", "lCollar", "lShldr"], "Poser, DAZ Studio or Second Life"),
    (&["LHipJoint", "LowerBack", "LThumb"], "CMU's conversions by B. Hahne (cgspeed)"),
    (&["lhipjoint", "lowerback", "lthumb"], "CMU's ASF files"),
    (&["joint_Root", "UpperLeg_L"], "Bandai Namco Research"),
];

/// Texts in the head of a file, and whose they are.
const BY_WORDS: [(&str, &str); 6] = [
    ("produced by endorphin", "NaturalMotion endorphin"),
    ("solidworks to urdf exporter", "SolidWorks to URDF Exporter"),
    ("sw2urdf", "SolidWorks to URDF Exporter"),
    ("onshape", "Onshape (onshape-to-robot)"),
    ("xacro", "xacro"),
    ("blender", "Blender"),
];

/// By the names of its joints.
pub(super) fn by_names(skeleton: &Skeleton) -> Option<&'static str> {
    if skeleton.joints.iter().any(|joint| joint.name.starts_with("mixamorig")) {
        return Some("Mixamo");
    }
    let has = |names: &&[&str]| names.iter().all(|name| skeleton.find(name).is_some());
    BY_NAMES.iter().find(|(names, _)| has(names)).map(|(_, maker)| *maker)
}

/// By what the file says: glTF's `generator`, a comment in the first lines of a text.
pub(super) fn by_text(path: &Path) -> Option<String> {
    const HEAD: usize = 1 << 16;
    let bytes = sinew_mocap::read::bytes(path).ok()?;
    let head = sinew_mocap::encoding::lossy(&bytes[..bytes.len().min(HEAD)]);
    if let Some((_, rest)) = head.split_once("\"generator\"") {
        let said = rest.split('"').nth(1)?;
        return Some(said.chars().take(80).collect());
    }
    // What is said of a maker stands in comments, before all else.
    let comments: String = head
        .lines()
        .take(20)
        .filter(|line| line.trim_start().starts_with(['#', '<', '!']) || line.contains("generated"))
        .collect::<Vec<_>>()
        .join("\n")
        .to_lowercase();
    BY_WORDS.iter().find(|(word, _)| comments.contains(word)).map(|(_, maker)| (*maker).to_owned())
}
