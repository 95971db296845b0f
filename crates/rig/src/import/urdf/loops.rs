//! Closed loops that a file has cut open.
//!
//! A URDF is a tree. Exporters mark a cut loop by two frames, `closing_NAME_1` and `closing_NAME_2`, which must
//! coincide, and joints without a drive by names with `passive` (onshape-to-robot).

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::note::{Notes, list};
use super::super::xml;
use super::graph::Tree;
use crate::description::JointType;
use crate::import::error::ImportError;
use crate::import::note::NoteKind;
use crate::import::options::Options;

/// Refuses a mechanism with closed loops, unless the user accepts the tree with open loops.
pub(super) fn refuse(
    robot: Node<'_, '_>,
    tree: &Tree<'_, '_>,
    options: &Options,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let loops = loops(tree);
    let passive: Vec<&str> = tree
        .joints
        .iter()
        .filter(|joint| joint.joint.kind != JointType::Fixed && joint.name.contains("passive"))
        .map(|joint| joint.name)
        .collect();
    if loops.is_empty() {
        for joint in passive {
            let text = "has no drive, by its name; the rig treats it like any other joint";
            notes.add_of(NoteKind::Doubtful, text, joint);
        }
        return Ok(());
    }
    let text = format!(
        "closed loops, cut open in the file: {}. Joints without a drive, by their names: {}",
        loops.join("; "),
        if passive.is_empty() { "none".to_owned() } else { list(&passive) }
    );
    if options.open_loops {
        let text = format!("{text}. The loops stay open, and these joints are as any other");
        notes.add(NoteKind::Doubtful, text);
        return Ok(());
    }
    let expected = "a tree in which every joint has a drive; the option cut (`--cut JOINT,..`) leaves joints out with \
                    all beyond them, open-loops (`--open-loops`) takes the tree as it is";
    Err(xml::refuse(robot, expected, format!("{} {text}", loops.len())))
}

/// Returns each pair of closing frames as text: its name, and the two links that meet there.
fn loops(tree: &Tree<'_, '_>) -> Vec<String> {
    let mut frames: BTreeMap<&str, [Option<&str>; 2]> = BTreeMap::new();
    for joint in &tree.joints {
        let Some(closing) = joint.joint.child.strip_prefix("closing_") else { continue };
        let (name, place) = match (closing.strip_suffix("_1"), closing.strip_suffix("_2")) {
            (Some(name), _) => (name, 0),
            (_, Some(name)) => (name, 1),
            _ => continue,
        };
        frames.entry(name).or_default()[place] = Some(&joint.joint.parent);
    }
    let pair = |(name, ends): (&str, [Option<&str>; 2])| match ends {
        [Some(one), Some(other)] => Some(format!("`{one}` meets `{other}` at closing_{name}")),
        _ => None,
    };
    frames.into_iter().filter_map(pair).collect()
}
