//! Reads joints of an MJCF.

use glam::{DQuat, DVec3};
use roxmltree::Node;

use super::super::note::Notes;
use super::super::{none, xml};
use super::defaults::{Element, MAIN};
use super::model::Model;
use super::pose::Pose;
use crate::description::{Joint, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// A joint, in the frame of the body that it moves.
pub(super) struct MjcfJoint {
    /// Name, type, axis and limits; parent, child and placement are added later.
    pub(super) joint: Joint,
    /// Point that the joint turns about, m.
    pub(super) anchor_m: DVec3,
    /// Pose at the joint's zero. The file draws the bodies at the position `ref`, which may differ from zero.
    pub(super) zero: Pose,
}

/// Reads a joint. `frame` is the pose of the enclosing `frame` elements in the body's frame.
pub(super) fn read(
    element: &Element<'_, '_>,
    name: String,
    frame: Pose,
    model: &Model<'_, '_, '_>,
    notes: &mut Notes,
) -> Result<MjcfJoint, ImportError> {
    let kind = match element.text("type") {
        _ if is_free(element) => JointType::Free,
        None | Some("hinge") => JointType::Revolute,
        Some("slide") => JointType::Prismatic,
        Some("ball") => JointType::Spherical,
        Some(_) => {
            return Err(xml::refuse_value(
                element.at("type"),
                "type",
                "hinge, slide, ball or free",
            ));
        }
    };
    let mut joint = Joint { name, kind, ..Joint::default() };
    if kind == JointType::Free {
        return Ok(MjcfJoint { joint, anchor_m: DVec3::ZERO, zero: Pose::IDENTITY });
    }
    let anchor = element.vector("pos")?.map_or(DVec3::ZERO, DVec3::from_array);
    let anchor_m = frame.position_m + frame.rotation * anchor;
    joint.rotor_inertia = Some(element.not_negative("armature")?).filter(|inertia| *inertia > 0.0);
    joint.friction =
        none::damping(element.at("frictionloss"), "frictionloss", 1, &joint.name, notes)?;
    joint.damping = none::damping(element.at("damping"), "damping", 3, &joint.name, notes)?;
    if element.not_negative("stiffness")? > 0.0 {
        notes.add_of(NoteKind::LeftOut, "springs of joints (stiffness)", &joint.name);
    }
    let range = element.range("range", "limited", model.auto_limits)?;
    if range.is_none() && element.text("range").is_some_and(is_flat) {
        let text = "a range whose ends are equal stands for none: the rig has none there";
        notes.add_of(NoteKind::LeftOut, text, &joint.name);
    }
    let range = range.and_then(|range| none::range("the range", range, &joint.name, notes));
    joint.effort = forces(element, &joint.name, model, notes)?
        .map(|[least, most]| least.abs().max(most.abs()));
    let mut zero = Pose::IDENTITY;
    let in_rad = |range: [f64; 2]| range.map(|angle| model.angles.rad(angle));
    if kind == JointType::Spherical {
        let most = range.map(|range| in_rad(range)[1].min(std::f64::consts::PI));
        joint.range_rad = most.map(|most| [0.0, most]).into_iter().collect();
        return Ok(MjcfJoint { joint, anchor_m, zero });
    }
    let axis = element.vector("axis")?.map_or(DVec3::Z, DVec3::from_array);
    let axis = (frame.rotation * axis)
        .try_normalize()
        .ok_or_else(|| xml::refuse_value(element.at("axis"), "axis", "an axis that is not zero"))?;
    // Adding zero converts -0 to 0.
    joint.axis = Some((axis + DVec3::ZERO).to_array());
    let reference = element.number("ref")?.unwrap_or(0.0);
    if kind == JointType::Revolute {
        joint.range_rad = range.map(in_rad).into_iter().collect();
        zero.rotation = DQuat::from_axis_angle(axis, -model.angles.rad(reference));
    } else {
        joint.range_m = range;
        zero.position_m = -reference * axis;
    }
    Ok(MjcfJoint { joint, anchor_m, zero })
}

/// Returns whether the two numbers of a range are equal.
fn is_flat(range: &str) -> bool {
    let mut ends = range.split_whitespace();
    let (least, most) = (ends.next(), ends.next());
    let number = |end: Option<&str>| end.and_then(|end| end.parse::<f64>().ok());
    number(least).zip(number(most)).is_some_and(|(least, most)| (most - least).abs() <= 0.0)
}

/// Returns the range of the joint's force from all its actuators, N m or N.
pub(super) fn forces(
    element: &Element<'_, '_>,
    name: &str,
    model: &Model<'_, '_, '_>,
    notes: &mut Notes,
) -> Result<Option<[f64; 2]>, ImportError> {
    let forces = element.range("actuatorfrcrange", "actuatorfrclimited", model.auto_limits)?;
    Ok(forces.and_then(|forces| none::range("actuatorfrcrange", forces, name, notes)))
}

/// Returns whether a joint permits all motion.
pub(super) fn is_free(element: &Element<'_, '_>) -> bool {
    element.node().has_tag_name("freejoint") || element.text("type") == Some("free")
}

/// Returns the joint position at which the file draws the bodies, rad or m.
pub(super) fn reference(
    element: &Element<'_, '_>,
    kind: JointType,
    model: &Model<'_, '_, '_>,
) -> Result<f64, ImportError> {
    let reference = element.number("ref")?.unwrap_or(0.0);
    Ok(if kind == JointType::Revolute { model.angles.rad(reference) } else { reference })
}

/// Finds a joint by its name, with its defaults.
pub(super) fn find<'a, 'd>(
    root: Node<'a, 'd>,
    name: &str,
    model: &Model<'a, 'd, '_>,
) -> Result<Option<Element<'a, 'd>>, ImportError> {
    let found = xml::children(root, "worldbody")
        .flat_map(|world| world.descendants())
        .find(|node| node.has_tag_name("joint") && node.attribute("name") == Some(name));
    let element = |node| model.defaults.element(node, &["joint"], class_around(node, model)?);
    found.map(element).transpose()
}

/// Returns the default class that the enclosing bodies and frames give an element.
fn class_around<'a, 'd>(
    node: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
) -> Result<usize, ImportError> {
    match node.ancestors().find(|outer| outer.has_attribute("childclass")) {
        Some(outer) => model.defaults.named(outer, "childclass", MAIN),
        None => Ok(MAIN),
    }
}
