//! Reads actuators of an MJCF: they give the maximum effort of joints. Gains are only reported in notes, because a
//! rig's gains belong to its servos.

use std::collections::BTreeSet;

use roxmltree::Node;

use super::super::note::Notes;
use super::super::xml;
use super::defaults::{Element, MAIN};
use super::model::Model;
use crate::description::{Description, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// Element names of actuators; MuJoCo stores the defaults of all of them together.
const TAGS: [&str; 6] = ["position", "motor", "general", "velocity", "intvelocity", "damper"];

pub(super) fn read<'a, 'd>(
    root: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &mut Description,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    // Joints that an earlier actuator drives: the effort limits of further actuators are added to theirs.
    let mut driven: BTreeSet<&str> = BTreeSet::new();
    let mut any = false;
    let sections = xml::children(root, "actuator").flat_map(|section| section.children());
    for node in sections.filter(Node::is_element) {
        any = true;
        let tag = node.tag_name().name();
        let joint = node.attribute("joint").or_else(|| node.attribute("jointinparent"));
        let (Some(kind), Some(name)) = (TAGS.iter().find(|known| **known == tag), joint) else {
            let text = "actuators that do not drive a single joint, or are not motors";
            notes.add_of(NoteKind::LeftOut, text, node.attribute("name").unwrap_or(tag));
            continue;
        };
        let mut tags = vec![*kind];
        tags.extend(TAGS.iter().filter(|known| **known != tag));
        let element = model.defaults.element(node, &tags, MAIN)?;
        let Some(joint) = single(description, name) else {
            if description.joints.iter().any(|joint| joint.name == name) {
                let text = "actuators of joints with several dofs";
                notes.add_of(NoteKind::LeftOut, text, name);
            } else if model.options.cut.is_empty() && !is_in_file(root, name) {
                return Err(xml::refuse_value(node, "joint", "a joint of the file"));
            }
            continue;
        };
        let limit = largest_effort(&element, tag, model)?;
        let is_first = driven.insert(name);
        match (limit, joint.effort) {
            (Some(limit), None) if is_first => joint.effort = Some(limit),
            // The joint's own limit is an upper bound.
            (Some(limit), Some(own)) if is_first => joint.effort = Some(limit.min(own)),
            (Some(limit), Some(sum)) => joint.effort = Some(sum + limit),
            _ => {}
        }
        if let Some(gains) = gains(&element, tag)? {
            let text = "gains of actuators: servos have their own";
            notes.add_of(NoteKind::LeftOut, text, format!("{name}: {gains}"));
        }
    }
    for joint in description.joints.iter().filter(|_| any) {
        let moves = !matches!(joint.kind, JointType::Fixed | JointType::Free);
        if moves && !driven.contains(joint.name.as_str()) {
            let text = "moves, but no actuator drives it; the rig treats it like any other joint";
            notes.add_of(NoteKind::Doubtful, text, &joint.name);
        }
    }
    Ok(())
}

fn is_in_file(root: Node<'_, '_>, name: &str) -> bool {
    let joint = |node: &Node<'_, '_>| node.has_tag_name("joint") || node.has_tag_name("freejoint");
    root.descendants().any(|node| joint(&node) && node.attribute("name") == Some(name))
}

/// Returns the maximum effort of an actuator at its joint, N m or N; `None` without limit.
fn largest_effort(
    element: &Element<'_, '_>,
    tag: &str,
    model: &Model<'_, '_, '_>,
) -> Result<Option<f64>, ImportError> {
    let most = |range: [f64; 2]| range[0].abs().max(range[1].abs());
    let forces = element.range("forcerange", "forcelimited", model.auto_limits)?.map(most);
    let controls = match tag {
        "motor" => element.range("ctrlrange", "ctrllimited", model.auto_limits)?.map(most),
        _ => None,
    };
    let force = match (forces, controls) {
        (Some(force), Some(control)) => Some(force.min(control)),
        (force, control) => force.or(control),
    };
    let gear = xml::numbers(element.at("gear"), "gear", 6)?;
    let gear = gear.and_then(|gear| gear.first().copied()).unwrap_or(1.0).abs();
    // A limit of zero means no limit.
    Ok(force.map(|force| force * gear).filter(|effort| *effort > 0.0))
}

/// Returns the gains as text.
fn gains(element: &Element<'_, '_>, tag: &str) -> Result<Option<String>, ImportError> {
    let gain = |name| element.number(name);
    Ok(match tag {
        "position" => {
            let (kp, kv) = (gain("kp")?.unwrap_or(1.0), gain("kv")?.unwrap_or(0.0));
            Some(format!("kp {kp}, kv {kv}"))
        }
        "velocity" | "damper" => Some(format!("kv {}", gain("kv")?.unwrap_or(1.0))),
        "intvelocity" => Some(format!("kp {}", gain("kp")?.unwrap_or(1.0))),
        "general" => element
            .text("biasprm")
            .or_else(|| element.text("gainprm"))
            .map(|gains| format!("general, {}", xml::shortened(gains))),
        _ => None,
    })
}

/// Finds a joint of one dof by name.
fn single<'a>(
    description: &'a mut Description,
    name: &str,
) -> Option<&'a mut crate::description::Joint> {
    let joint = description.joints.iter_mut().find(|joint| joint.name == name)?;
    matches!(joint.kind, JointType::Revolute | JointType::Prismatic).then_some(joint)
}
