//! Reads the rig in a URDF file (the Unified Robot Description Format of ROS), in its zero pose and without a
//! skin.
//!
//! The rig's moving joints are the character's, from the root outwards. The root is the link that no joint moves;
//! it floats. Links on fixed joints become part of their parent link. If that link carries no moving joint, the
//! farthest fixed joint remains, as the end of the link's bone. If a joint has the root link's name too, the root
//! is called `NAME (link)`. A joint is at the frame of its child link. URDF has x ahead, y left and z up (ROS REP
//! 103); characters have x left, y up and z ahead.

use std::collections::{BTreeMap, BTreeSet};

use glam::{DMat3, DVec3};
use roxmltree::Node;
use sinew_mocap::encoding;
use sinew_rig::import::document;

use super::error::{FilePosition, Refusal, refuse};
use super::limits::JOINT_COUNT_MAX;
use super::model::{Character, Joint};

/// Parses the text of a file.
///
/// # Errors
/// [`Refusal`] with line and column if it is not XML or not a robot, or its joints and links are not a tree.
pub(super) fn parse(bytes: &[u8], name: String) -> Result<Character, Refusal> {
    let text = encoding::decoded(bytes).map_err(|error| {
        refuse("a URDF", "text in UTF-8 or UTF-16", "other bytes")
            .at(FilePosition::Byte(error.at()))
    })?;
    let document = document(&text).map_err(|error| {
        let at = FilePosition::Line(error.place.line, error.place.column);
        refuse("a URDF", error.expected, error.found).at(at)
    })?;
    let robot = document.root_element();
    if !robot.has_tag_name("robot") {
        let found = format!("`{}`", robot.tag_name().name());
        return Err(refuse("a URDF", "the element `robot`", found).at(place(robot)));
    }
    let links = links(robot)?;
    if links.is_empty() {
        return Err(refuse("the robot", "a link", "none").at(place(robot)));
    }
    let count = children(robot, "joint").count();
    if count >= JOINT_COUNT_MAX {
        let expected = format!("at most {} joints", JOINT_COUNT_MAX - 1);
        return Err(refuse("the robot", expected, count));
    }
    let joints: Vec<UrdfJoint<'_, '_>> = children(robot, "joint")
        .map(|joint| UrdfJoint::read(joint, &links))
        .collect::<Result<_, _>>()?;
    // The joint that moves each link.
    let mut movers: BTreeMap<&str, usize> = BTreeMap::new();
    for (index, joint) in joints.iter().enumerate() {
        if let Some(first) = movers.insert(joint.child, index) {
            let item = format!("link `{}`", joint.child);
            let found = format!("`{}` and `{}`", joints[first].name, joint.name);
            return Err(refuse(item, "one joint that moves it", found).at(place(joint.node)));
        }
    }
    let mut roots = links.iter().filter(|link| !movers.contains_key(**link));
    let root = match (roots.next(), roots.next()) {
        (Some(root), None) => *root,
        (None, _) => return Err(refuse("the robot", "a link that no joint moves", "a loop")),
        (Some(a), Some(b)) => {
            let found = format!("`{a}` and `{b}`");
            return Err(refuse("the robot", "one link that no joint moves", found));
        }
    };
    let positions_m: Vec<DVec3> = joints
        .iter()
        .map(|joint| {
            // Every path upwards ends at the root, unless it contains a cycle.
            let way = std::iter::successors(Some(joint), |joint| {
                movers.get(joint.parent).map(|index| &joints[*index])
            });
            let (mut position_m, mut steps) = (DVec3::ZERO, 0);
            for joint in way.take(joints.len() + 1) {
                position_m = joint.origin_m + joint.rotation * position_m;
                steps += 1;
            }
            if steps <= joints.len() {
                return Ok(position_m);
            }
            let item = format!("joint `{}`", joint.name);
            Err(refuse(item, "ancestors that end at a root", "a loop").at(place(joint.node)))
        })
        .collect::<Result<_, _>>()?;
    let mut root_name = root.to_owned();
    while joints.iter().any(|joint| joint.name == root_name) {
        root_name.push_str(" (link)");
    }
    let mut made = vec![Joint { name: root_name, parent: None, position_m: DVec3::ZERO }];
    // Depth first from the root, since files may have any order. The stack contains joints with the place of the
    // joint that moves their link; the next joint is last.
    let on = |link: &str, place: usize| {
        let on_link =
            joints.iter().enumerate().rev().filter(move |(_, joint)| joint.parent == link);
        on_link.map(move |(index, _)| (index, place)).collect::<Vec<_>>()
    };
    let mut to_come = on(root, 0);
    let made_of = |index: usize, parent: usize| {
        let position_m = in_character(positions_m[index]);
        Joint { name: joints[index].name.to_owned(), parent: Some(parent), position_m }
    };
    // For each joint in `made`, the farthest fixed joint on its link.
    let mut ends: BTreeMap<usize, Joint> = BTreeMap::new();
    while let Some((index, parent)) = to_come.pop() {
        let joint = made_of(index, parent);
        if joints[index].is_fixed {
            to_come.extend(on(joints[index].child, parent));
            let far = |end: &Joint| end.position_m.distance(made[parent].position_m);
            if far(&joint) > ends.get(&parent).map_or(0.0, far) {
                ends.insert(parent, joint);
            }
        } else {
            to_come.extend(on(joints[index].child, made.len()));
            made.push(joint);
        }
    }
    ends.retain(|place, _| made.iter().all(|joint| joint.parent != Some(*place)));
    made.extend(ends.into_values());
    Character::new(name, made, None)
}

/// Converts URDF axes to a character's axes.
pub(super) fn in_character(v: DVec3) -> DVec3 {
    DVec3::new(v.y, v.z, v.x)
}

/// Valid types of a joint.
const TYPES: [&str; 6] = ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];

/// Maximum angle. Larger angles indicate damage: f64 has fewer digits left within a turn.
const ANGLE_MAX_RAD: f64 = 1e6;

/// A joint of the file, in its parent link's frame.
struct UrdfJoint<'a, 'b> {
    name: &'a str,
    parent: &'a str,
    child: &'a str,
    origin_m: DVec3,
    rotation: DMat3,
    is_fixed: bool,
    /// Node of the joint. Its line is computed only for a message, since that requires a scan of the file.
    node: Node<'a, 'b>,
}

impl<'a, 'b> UrdfJoint<'a, 'b> {
    fn read(joint: Node<'a, 'b>, links: &BTreeSet<&str>) -> Result<Self, Refusal> {
        let name = attribute(joint, "name")?;
        let in_joint = |refusal: Refusal| refusal.of(format!("joint `{name}`")).at(place(joint));
        let joint_type = attribute(joint, "type").map_err(in_joint)?;
        if !TYPES.contains(&joint_type) {
            let expected = format!("one of {}", TYPES.join(", "));
            return Err(in_joint(refuse("type", expected, format!("`{joint_type}`"))));
        }
        let link = |tag: &str| {
            let node = only_child(joint, tag)?;
            let node = node.ok_or_else(|| refuse(tag, "an element of this name", "none"))?;
            let link = attribute(node, "link")?;
            if links.contains(link) {
                return Ok(link);
            }
            let found = format!("`{link}`");
            Err(refuse(tag, "a link of the robot", found).at(place(node)))
        };
        let (parent, child) = (link("parent").map_err(in_joint)?, link("child").map_err(in_joint)?);
        let origin = only_child(joint, "origin").map_err(in_joint)?;
        let vector = |name, expected, max| {
            let vector =
                origin.map_or(Ok(DVec3::ZERO), |origin| vector(origin, name, expected, max));
            vector.map_err(in_joint)
        };
        let origin_m = vector("xyz", "three finite numbers", f64::MAX)?;
        // Roll, pitch and yaw about the parent's axes, in this order.
        let expected = "three angles of at most 1000000 rad";
        let DVec3 { x: roll, y: pitch, z: yaw } = vector("rpy", expected, ANGLE_MAX_RAD)?;
        let rotation = DMat3::from_rotation_z(yaw)
            * DMat3::from_rotation_y(pitch)
            * DMat3::from_rotation_x(roll);
        let is_fixed = joint_type == "fixed";
        Ok(Self { name, parent, child, origin_m, rotation, is_fixed, node: joint })
    }
}

/// Returns the names of the links.
fn links<'a>(robot: Node<'a, '_>) -> Result<BTreeSet<&'a str>, Refusal> {
    let mut links = BTreeSet::new();
    for link in children(robot, "link") {
        let name = attribute(link, "name")?;
        if !links.insert(name) {
            let item = format!("link `{name}`");
            return Err(refuse(item, "a name of its own", "that of another link").at(place(link)));
        }
    }
    Ok(links)
}

fn children<'a, 'b>(node: Node<'a, 'b>, tag: &str) -> impl Iterator<Item = Node<'a, 'b>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

/// Returns the element of this name; `None` if there is none.
fn only_child<'a, 'b>(node: Node<'a, 'b>, tag: &str) -> Result<Option<Node<'a, 'b>>, Refusal> {
    let mut found = children(node, tag);
    let first = found.next();
    match found.next() {
        None => Ok(first),
        Some(second) => {
            let expected = "one element of this name";
            Err(refuse(tag, expected, 2 + found.count()).at(place(second)))
        }
    }
}

fn attribute<'a>(node: Node<'a, '_>, name: &str) -> Result<&'a str, Refusal> {
    node.attribute(name).filter(|value| !value.is_empty()).ok_or_else(|| {
        let item = format!("`{}`", node.tag_name().name());
        refuse(item, format!("the attribute `{name}`"), "none").at(place(node))
    })
}

/// Returns three numbers of at most `max`, which `expected` describes; zeros if the attribute is missing.
fn vector(node: Node<'_, '_>, name: &str, expected: &str, max: f64) -> Result<DVec3, Refusal> {
    let Some(text) = node.attribute(name) else { return Ok(DVec3::ZERO) };
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(|word| word.parse().ok()).collect();
    let vector = numbers.and_then(|numbers| <[f64; 3]>::try_from(numbers).ok());
    vector
        .map(DVec3::from)
        .filter(|vector| vector.is_finite() && vector.abs().max_element() <= max)
        .ok_or_else(|| refuse(name, expected, format!("`{text}`")).at(place(node)))
}

fn place(node: Node<'_, '_>) -> FilePosition {
    let at = node.document().text_pos_at(node.range().start);
    FilePosition::Line(at.row, at.col)
}
