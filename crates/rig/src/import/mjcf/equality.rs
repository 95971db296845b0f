//! Reads equalities of an MJCF: closed loops, and joints that follow other joints.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::super::note::{Notes, list};
use super::super::tie::Tie;
use super::super::xml;
use super::model::Model;
use super::{joint, tendon};
use crate::description::{Description, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

pub(super) fn read<'a, 'd>(
    root: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &Description,
    notes: &mut Notes,
) -> Result<Vec<Tie>, ImportError> {
    let (mut ties, mut loops) = (Vec::new(), Vec::new());
    let bodies: BTreeSet<&str> = description.bodies.iter().map(|body| body.name.as_str()).collect();
    let sections = xml::children(root, "equality").flat_map(|section| section.children());
    for node in sections.filter(Node::is_element) {
        let tag = node.tag_name().name();
        if node.attribute("active") == Some("false") {
            notes.add_of(NoteKind::LeftOut, "equalities that are not active", tag);
            continue;
        }
        match tag {
            "connect" | "weld" => {
                let ends = ["body1", "body2", "site1", "site2"];
                let ends: Vec<&str> = ends.iter().filter_map(|end| node.attribute(*end)).collect();
                let is_left_out = |end: &&&str| !bodies.contains(**end);
                if node.has_attribute("body1") && ends.iter().any(|end| is_left_out(&end)) {
                    let text = "equalities of bodies that are left out";
                    notes.add_of(NoteKind::LeftOut, text, ends.join(" to "));
                } else if ends.len() == 1
                    && description.bodies.first().is_some_and(|base| base.name == ends[0])
                {
                    notes.add_of(
                        NoteKind::LeftOut,
                        "equality that holds the base: a rig's base is held already",
                        ends[0],
                    );
                } else {
                    loops.push((node, ends));
                }
            }
            "joint" => ties.extend(tie(root, node, model, description, notes)?),
            "tendon" => ties.extend(tendon::tie(root, node, model, description, notes)?),
            _ => {
                notes.add_of(NoteKind::LeftOut, "equalities that are not of bodies or joints", tag);
            }
        }
    }
    let Some((first, _)) = loops.first() else { return Ok(ties) };
    let text: Vec<String> = loops
        .iter()
        .map(|(node, ends)| format!("{} of {}", node.tag_name().name(), list(ends)))
        .collect();
    let text = format!("{} closed loops: {}", loops.len(), text.join("; "));
    if model.options.open_loops {
        notes.add(NoteKind::Doubtful, format!("{text}. They stay open"));
        return Ok(ties);
    }
    let expected = "a tree; the option cut leaves joints out with all beyond them, open-loops leaves these equalities out";
    Err(xml::refuse(*first, expected, text))
}

/// Reads a joint that follows another: `q1 - ref1 = a + b (q2 - ref2)`.
fn tie<'a, 'd>(
    root: Node<'a, 'd>,
    node: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &Description,
    notes: &mut Notes,
) -> Result<Option<Tie>, ImportError> {
    let joint = xml::required(node, "joint1")?;
    let factors = xml::numbers(node, "polycoef", 5)?.unwrap_or_else(|| vec![0.0, 1.0]);
    let factor = |place: usize| factors.get(place).copied().unwrap_or(0.0);
    let Some(of) = node.attribute("joint2") else {
        notes.add_of(NoteKind::LeftOut, "a joint that an equality holds in one place", joint);
        return Ok(None);
    };
    if (2..5).any(|place| factor(place).abs() > 0.0) {
        let text = "joints that follow others along a curve: nothing ties them, until one servo drives both";
        notes.add_of(NoteKind::LeftOut, text, format!("{joint} after {of}"));
        return Ok(None);
    }
    let mut references = [0.0; 2];
    for (slot, (name, attribute)) in references.iter_mut().zip([(joint, "joint1"), (of, "joint2")])
    {
        let Some(element) = joint::find(root, name, model)? else {
            return Err(xml::refuse_value(node, attribute, "a joint of the file"));
        };
        let kind = description.joints.iter().find(|joint| joint.name == name);
        let kind = kind.map_or(JointType::Fixed, |joint| joint.kind);
        *slot = joint::reference(&element, kind, model)?;
    }
    let [reference, reference_of] = references;
    let offset = factor(0) + reference - factor(1) * reference_of;
    Ok(Some(Tie { joint: joint.to_owned(), of: of.to_owned(), multiplier: factor(1), offset }))
}
