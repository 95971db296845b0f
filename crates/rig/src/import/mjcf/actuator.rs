//! Reads actuators of an MJCF: they give the maximum effort of joints. Gains are only reported in notes, because a
//! rig's gains belong to its servos.

use std::collections::BTreeMap;

use roxmltree::Node;

use super::super::note::Notes;
use super::super::{none, xml};
use super::actuator_force::{ActuatorForce, TAGS};
use super::model::Model;
use super::{joint, tendon};
use crate::description::{Description, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// Lowest and highest sum of the forces of a joint's actuators, N m or N, by the joint's name.
type Sums<'a> = BTreeMap<&'a str, [f64; 2]>;

/// Reads all actuators. The effort of a joint is the largest absolute force that its actuators make together at the
/// ends of their control ranges, within the joint's own limit.
pub(super) fn read<'a, 'd>(
    root: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &mut Description,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let mut sums = Sums::new();
    let mut any = false;
    let sections = xml::children(root, "actuator").flat_map(|section| section.children());
    for node in sections.filter(Node::is_element) {
        any = true;
        let tag = node.tag_name().name();
        let nodes = model.defaults.in_order(node, &TAGS)?;
        let force = TAGS.contains(&tag).then(|| ActuatorForce::read(&nodes)).transpose()?;
        let Some(force) = force.filter(|force| !force.is_other()) else {
            let text = "actuators whose force does not follow their control in a line";
            notes.add_of(NoteKind::LeftOut, text, node.attribute("name").unwrap_or(tag));
            continue;
        };
        let joint = node.attribute("joint").or_else(|| node.attribute("jointinparent"));
        let moved = match (joint, node.attribute("tendon")) {
            (Some(name), _) => vec![(name, 1.0)],
            (None, Some(name)) => tendon::fixed(root, name)?.unwrap_or_default(),
            (None, None) => Vec::new(),
        };
        if moved.is_empty() {
            let text = "actuators that drive neither a joint nor a tendon of joints";
            notes.add_of(NoteKind::LeftOut, text, node.attribute("name").unwrap_or(tag));
            continue;
        }
        let mut position = 0.0;
        for (name, factor) in &moved {
            position += factor * rest(root, name, model, description)?;
        }
        for (name, factor) in moved {
            let Some(joint) = single(description, name) else {
                if description.joints.iter().any(|joint| joint.name == name) {
                    let text = "actuators of joints with several dofs";
                    notes.add_of(NoteKind::LeftOut, text, name);
                } else if model.options.cut.is_empty() && !is_in_file(root, name) {
                    return Err(xml::refuse_value(node, "joint", "a joint of the file"));
                }
                continue;
            };
            let range = joint.range_m.or_else(|| joint.range_rad.first().copied());
            let ends = force.ends(position, range, model.auto_limits).map(|end| factor * end);
            let sum = sums.entry(name).or_default();
            *sum = [sum[0] + ends[0].min(ends[1]), sum[1] + ends[0].max(ends[1])];
            if let Some(gains) = force.gains() {
                let text = "gains of actuators: servos have their own";
                notes.add_of(NoteKind::LeftOut, text, format!("{name}: {gains}"));
            }
        }
    }
    for joint in description.joints.iter_mut().filter(|_| any) {
        let moves = !matches!(joint.kind, JointType::Fixed | JointType::Free);
        match sums.get(joint.name.as_str()) {
            Some(sum) => {
                let own = own_forces(root, &joint.name, model)?;
                joint.effort = effort(*sum, own, &joint.name, notes);
            }
            None if moves => {
                let text =
                    "moves, but no actuator drives it; the rig treats it like any other joint";
                notes.add_of(NoteKind::Doubtful, text, &joint.name);
            }
            None => {}
        }
    }
    Ok(())
}

/// Returns the effort of a joint, N m or N; `None` without limit.
fn effort(
    [least, most]: [f64; 2],
    own: Option<[f64; 2]>,
    name: &str,
    notes: &mut Notes,
) -> Option<f64> {
    let [low, high] = own.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
    let within = |force: f64| force.max(low).min(high).abs();
    let effort = within(least).max(within(most));
    if effort.is_finite() && none::is_endless(effort) {
        let text =
            format!("the force {} stands for none: the rig has none there", none::short(effort));
        notes.add_of(NoteKind::LeftOut, text, name);
        return None;
    }
    // A limit of zero means no limit.
    Some(effort).filter(|effort| effort.is_finite() && *effort > 0.0)
}

/// Returns the joint's own limit on the sum of its actuators' forces. The note on this limit was added with the joint.
fn own_forces<'a, 'd>(
    root: Node<'a, 'd>,
    name: &str,
    model: &Model<'a, 'd, '_>,
) -> Result<Option<[f64; 2]>, ImportError> {
    let Some(element) = joint::find(root, name, model)? else { return Ok(None) };
    joint::forces(&element, name, model, &mut Notes::default())
}

/// Returns the position of a joint as the file draws it, rad or m.
fn rest<'a, 'd>(
    root: Node<'a, 'd>,
    name: &str,
    model: &Model<'a, 'd, '_>,
    description: &Description,
) -> Result<f64, ImportError> {
    let Some(element) = joint::find(root, name, model)? else { return Ok(0.0) };
    let kind = description.joints.iter().find(|joint| joint.name == name);
    joint::reference(&element, kind.map_or(JointType::Fixed, |joint| joint.kind), model)
}

fn is_in_file(root: Node<'_, '_>, name: &str) -> bool {
    let joint = |node: &Node<'_, '_>| node.has_tag_name("joint") || node.has_tag_name("freejoint");
    root.descendants().any(|node| joint(&node) && node.attribute("name") == Some(name))
}

/// Finds a joint of one dof by name.
fn single<'a>(
    description: &'a mut Description,
    name: &str,
) -> Option<&'a mut crate::description::Joint> {
    let joint = description.joints.iter_mut().find(|joint| joint.name == name)?;
    matches!(joint.kind, JointType::Revolute | JointType::Prismatic).then_some(joint)
}
