//! Finds the program or company that wrote a file: from texts in the file, or from joint names that only one program
//! uses.

use std::path::Path;

use sinew_mocap::Skeleton;

/// Joint names that all files of a program have and other files lack, and the program.
const BY_NAMES: [(&[&str], &str); 7] = [
    (&["Hips", "Chest4", "LeftCollar"], "Xsens MVN"),
    (&["Hips", "Spine3", "LeftInHandIndex"], "Axis Neuron (Perception Neuron)"),
    (&["root", "torso_7", "neck_2", "l_low_leg"], "mocopi"),
    (&["hip", "abdomen", "lCollar", "lShldr"], "Poser, DAZ Studio or Second Life"),
    (&["LHipJoint", "LowerBack", "LThumb"], "CMU's conversions by B. Hahne (cgspeed)"),
    (&["lhipjoint", "lowerback", "lthumb"], "CMU's ASF files"),
    (&["joint_Root", "UpperLeg_L"], "Bandai Namco Research"),
];

/// Texts in the first part of a file, and the program that writes them.
const BY_WORDS: [(&str, &str); 6] = [
    ("produced by endorphin", "NaturalMotion endorphin"),
    ("solidworks to urdf exporter", "SolidWorks to URDF Exporter"),
    ("sw2urdf", "SolidWorks to URDF Exporter"),
    ("onshape", "Onshape (onshape-to-robot)"),
    ("xacro", "xacro"),
    ("blender", "Blender"),
];

/// Returns the program that uses the names of these joints; `None` if none is known.
pub(super) fn by_names(skeleton: &Skeleton) -> Option<&'static str> {
    if skeleton.joints.iter().any(|joint| joint.name.starts_with("mixamorig")) {
        return Some("Mixamo");
    }
    let has = |names: &&[&str]| names.iter().all(|name| skeleton.find(name).is_some());
    BY_NAMES.iter().find(|(names, _)| has(names)).map(|(_, maker)| *maker)
}

/// Returns the program that the file names: glTF's `generator`, or a comment in the first lines of a text.
pub(super) fn by_text(path: &Path) -> Option<String> {
    const HEAD: usize = 1 << 16;
    let bytes = sinew_mocap::read::bytes(path).ok()?;
    let head = sinew_mocap::encoding::lossy(&bytes[..bytes.len().min(HEAD)]);
    if let Some((_, rest)) = head.split_once("\"generator\"") {
        let said = rest.split('"').nth(1)?;
        return Some(said.chars().take(80).collect());
    }
    // The program is named in comments in the first lines.
    let comments: String = head
        .lines()
        .take(20)
        .filter(|line| line.trim_start().starts_with(['#', '<', '!']) || line.contains("generated"))
        .collect::<Vec<_>>()
        .join("\n")
        .to_lowercase();
    BY_WORDS.iter().find(|(word, _)| comments.contains(word)).map(|(_, maker)| (*maker).to_owned())
}
