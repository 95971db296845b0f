//! Reads URDF, the Unified Robot Description Format of ROS: links, and joints that name them.

mod graph;
mod joint;
mod limits;
mod link;
mod loops;
mod shapes;

use std::collections::{BTreeMap, BTreeSet};

use glam::DQuat;
use roxmltree::Node;

use super::error::ImportError;
use super::imported::Imported;
use super::note::{NoteKind, Notes, list};
use super::options::Options;
use super::world::World;
use super::{tie, xml};
use crate::description::{Description, JointType};
use crate::import::imported;
use joint::UrdfJoint;

pub(super) fn read(text: &str, options: &Options) -> Result<Imported, ImportError> {
    let text = xml::with_declaration_first(text);
    let document = xml::document(&text)?;
    let robot = document.root_element();
    if !robot.has_tag_name("robot") {
        let found = format!("`{}`", robot.tag_name().name());
        return Err(xml::refuse(robot, "`robot`, the first element of a URDF", found));
    }
    refuse_macros(robot)?;

    let mut notes = Notes::default();
    let links: Vec<Node<'_, '_>> = xml::children(robot, "link").collect();
    let places = names(&links)?;
    if links.is_empty() {
        return Err(xml::refuse(robot, "a link", "none"));
    }
    let joint_nodes: Vec<Node<'_, '_>> = xml::children(robot, "joint").collect();
    let joint_places = names(&joint_nodes)?;
    let joints: Vec<UrdfJoint<'_, '_>> = joint_nodes
        .iter()
        .map(|joint| UrdfJoint::read(*joint, &places, &mut notes))
        .collect::<Result<_, _>>()?;
    let tree = graph::tree(robot, &links, joints, options, &mut notes)?;
    loops::refuse(robot, &tree, options, &mut notes)?;

    let balance = options.repair_inertia || balances_inertia(robot);
    let bodies = link::bodies(&tree.links, balance, options.repair_inertia, &mut notes)?;
    let mut description = imported::empty(robot.attribute("name"));
    description.bodies = bodies;
    description.joints = tree.joints.iter().map(|joint| joint.joint.clone()).collect();
    let world = World::of(options, None);
    world.stand(&mut description, &mut notes);
    stand(&mut description, &mut notes);
    let ties = tree
        .joints
        .iter()
        .filter_map(|joint| joint.mimic.map(|mimic| mimic.tie(joint, &joint_places)))
        .collect::<Result<Vec<_>, _>>()?;
    tie::tie(&ties, &mut description, &mut notes);
    limits::doubt(&mut description.joints, &mut notes);
    tell_actuators(robot, &description, &mut notes);
    imported::tell_massless(&description, &mut notes);
    tell_unread(robot, &tree.links, &tree.joints, &mut notes);
    imported::finish(robot, world, description, notes)
}

/// Returns the index of each element in its list, by name.
fn names<'a>(nodes: &[Node<'a, '_>]) -> Result<BTreeMap<&'a str, usize>, ImportError> {
    let mut places = BTreeMap::new();
    for (place, node) in nodes.iter().enumerate() {
        let name = xml::required(*node, "name")?;
        if places.insert(name, place).is_some() {
            let tag = node.tag_name().name();
            return Err(xml::refuse_value(
                *node,
                "name",
                format!("a name that no other {tag} has"),
            ));
        }
    }
    Ok(places)
}

/// Refuses a file for xacro: it has elements of the xacro namespace, or expressions in values.
fn refuse_macros(robot: Node<'_, '_>) -> Result<(), ImportError> {
    for node in robot.descendants().filter(Node::is_element) {
        let tag = node.tag_name();
        if tag.namespace().is_some_and(|uri| uri.contains("xacro")) {
            return Err(xml::refuse(node, xml::XACRO, format!("`xacro:{}`", tag.name())));
        }
        let macros = |value: &str| value.contains("${") || value.contains("$(");
        if let Some(attribute) = node.attributes().find(|attribute| macros(attribute.value())) {
            return Err(xml::refuse_value(node, attribute.name(), xml::XACRO));
        }
    }
    Ok(())
}

/// Returns whether the file's `mujoco` element asks to repair inertia.
fn balances_inertia(robot: Node<'_, '_>) -> bool {
    xml::children(robot, "mujoco")
        .flat_map(|mujoco| xml::children(mujoco, "compiler"))
        .any(|compiler| compiler.attribute("balanceinertia") == Some("true"))
}

/// Removes a base without mass on a free joint; the floating body becomes the base.
fn stand(description: &mut Description, notes: &mut Notes) {
    let on_base = |base: &str| {
        let mut on_base = description.joints.iter().enumerate().filter(|(_, j)| j.parent == base);
        match (on_base.next(), on_base.next()) {
            (Some((place, joint)), None) if joint.kind == JointType::Free => Some(place),
            _ => None,
        }
    };
    let Some(base) = description.bodies.first().filter(|body| body.mass_kg <= 0.0) else { return };
    let Some(place) = on_base(&base.name) else { return };
    let joint = description.joints.remove(place);
    let base = description.bodies.remove(0);
    imported::place_base(
        description,
        joint.position_m.into(),
        DQuat::from_array(joint.rotation_xyzw),
    );
    let text = format!(
        "`{}` floats by the joint `{}`, on `{}` that has no mass: it is the base, which is fixed, as on a stand. To \
         let the base move: mount.base = \"driven\"",
        joint.child, joint.name, base.name
    );
    notes.add(NoteKind::Changed, text);
}

/// Adds a note on the joints that the file lists as actuated, if it lists any.
fn tell_actuators(robot: Node<'_, '_>, description: &Description, notes: &mut Notes) {
    let groups = ["transmission", "ros2_control"];
    let driven: BTreeSet<&str> = groups
        .into_iter()
        .flat_map(|group| xml::children(robot, group))
        .flat_map(|group| xml::children(group, "joint"))
        .filter_map(|joint| joint.attribute("name"))
        .collect();
    if driven.is_empty() {
        return;
    }
    for joint in description.joints.iter().filter(|joint| joint.kind != JointType::Fixed) {
        if !driven.contains(joint.name.as_str()) {
            let text = "moves, but the file's transmissions do not drive it; the rig treats it like any other joint";
            notes.add_of(NoteKind::Doubtful, text, &joint.name);
        }
    }
}

/// Adds notes on elements without meaning for a rig, counted by name.
fn tell_unread(
    robot: Node<'_, '_>,
    links: &[Node<'_, '_>],
    joints: &[UrdfJoint<'_, '_>],
    notes: &mut Notes,
) {
    const OF_ROBOT: [&str; 3] = ["link", "joint", "material"];
    const OF_LINK: [&str; 3] = ["inertial", "visual", "collision"];
    const OF_JOINT: [&str; 7] = ["origin", "parent", "child", "axis", "limit", "dynamics", "mimic"];
    let mut unread: BTreeMap<String, usize> = BTreeMap::new();
    let mut count = |node: Node<'_, '_>, read: &[&str], of: &str| {
        for child in node.children().filter(Node::is_element) {
            let tag = child.tag_name().name();
            if !read.contains(&tag) {
                *unread.entry(format!("{}{of}", xml::shortened(tag))).or_default() += 1;
            }
        }
    };
    count(robot, &OF_ROBOT, "");
    for link in links {
        count(*link, &OF_LINK, " of a link");
    }
    for joint in joints {
        count(joint.node, &OF_JOINT, " of a joint");
    }
    for (what, count) in unread {
        let text = "elements that a rig does not need, or in a place where URDF has none";
        notes.add_of(NoteKind::LeftOut, text, format!("{what}: {count}"));
    }
    let meshes = links.iter().flat_map(Node::descendants);
    let meshes: BTreeSet<&str> = meshes
        .filter(|node| node.has_tag_name("mesh"))
        .filter_map(|mesh| mesh.attribute("filename"))
        .collect();
    if !meshes.is_empty() {
        let shown: Vec<&str> = meshes.iter().copied().collect();
        let text = format!("meshes, which are not read: {} files", shown.len());
        let name = |file: &str| xml::shortened(file.rsplit('/').next().unwrap_or(file));
        let first: Vec<String> = shown.iter().take(3).map(|file| name(file)).collect();
        notes.add(NoteKind::LeftOut, format!("{text}, such as {}", list(&first)));
    }
}
