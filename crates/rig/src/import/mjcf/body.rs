//! Reads bodies of an MJCF, from the world outwards.

use glam::{DQuat, DVec3};
use roxmltree::Node;

use super::super::note::{Notes, list};
use super::super::xml;
use super::defaults::MAIN;
use super::joint::{self, MjcfJoint};
use super::mass;
use super::model::Model;
use super::names::Names;
use super::parts::Parts;
use super::pose::Pose;
use super::shapes;
use crate::description::mass::Mass;
use crate::description::{Body, Description, Joint, JointType};
use crate::import::error::ImportError;
use crate::import::imported;
use crate::import::note::NoteKind;

/// A body that is not read yet.
struct ToCome<'a, 'd> {
    parts: Parts<'a, 'd>,
    /// Name of its parent body in the rig; `None` for the base.
    parent: Option<String>,
    /// Pose of the body's frame in the parent's frame.
    frame: Pose,
}

/// Reads all bodies into the rig.
pub(super) fn read<'a, 'd>(
    root: Node<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    description: &mut Description,
    notes: &mut Notes,
) -> Result<(), ImportError> {
    let mut names = Names::read(root)?;
    names.refuse_unknown_cuts(root, model.options)?;
    let mut top = Vec::new();
    for world in xml::children(root, "worldbody") {
        let class = model.defaults.named(world, "childclass", MAIN)?;
        let world = Parts::read(world, class, model)?;
        top.extend(inside(world.bodies, None, DVec3::ZERO, model, notes)?);
    }
    if top.is_empty() {
        return Err(xml::refuse(root, "a body in `worldbody`", "none"));
    }
    refuse_several_robots(root, &top)?;
    let is_base =
        |body: &ToCome<'_, '_>| body.parts.joints.iter().all(|(joint, _)| joint::is_free(joint));
    if !(top.len() == 1 && top.iter().all(is_base)) {
        let world = Names::fresh(&mut names.bodies, "world");
        description.bodies.push(Mass::point(0.0).body(&world));
        for body in &mut top {
            body.parent = Some(world.clone());
        }
    }
    top.reverse();
    while let Some(body) = top.pop() {
        let on_body = read_body(body, model, &mut names, description, notes)?;
        top.extend(on_body.into_iter().rev());
    }
    Ok(())
}

/// Reads one body into the rig, and returns its child bodies.
fn read_body<'a, 'd>(
    body: ToCome<'a, 'd>,
    model: &Model<'a, 'd, '_>,
    names: &mut Names,
    description: &mut Description,
    notes: &mut Notes,
) -> Result<Vec<ToCome<'a, 'd>>, ImportError> {
    let ToCome { parts, parent, frame } = body;
    let name = match parts.name() {
        Some(name) => name.to_owned(),
        None => Names::fresh(&mut names.bodies, "body"),
    };
    tell_quirks(parts.node, &name, notes);
    let mass = mass::of_body(&parts, &name, model, notes)?;
    let pose = frame.then(model.angles.pose(parts.node)?);
    let mut joints = Vec::new();
    for (element, frame) in &parts.joints {
        if joint::is_free(element) && parts.joints.len() > 1 {
            let found = format!("{} joints", parts.joints.len());
            return Err(xml::refuse(element.node(), "a free joint alone in its body", found));
        }
        let joint_name = match element.node().attribute("name").filter(|name| !name.is_empty()) {
            Some(name) => name.to_owned(),
            None => Names::fresh(&mut names.joints, &name),
        };
        joints.push(joint::read(element, joint_name, *frame, model, notes)?);
    }
    let shift_m = match parent {
        None => {
            stand(&name, !joints.is_empty(), pose, description, notes);
            DVec3::ZERO
        }
        Some(parent) => hang(&name, joints, parent, pose, names, description, notes),
    };
    description.bodies.push(Body {
        shapes: shapes::of_body(&parts, shift_m, model),
        ..mass.seen_from(DQuat::IDENTITY, -shift_m).body(&name)
    });
    inside(parts.bodies, Some(&name), shift_m, model, notes)
}

/// Returns the bodies inside another body, except those that the user cuts. `shift_m` is the origin of the rig's
/// body in the frame of the file's body.
fn inside<'a, 'd>(
    bodies: Vec<(Node<'a, 'd>, Pose, usize)>,
    parent: Option<&str>,
    shift_m: DVec3,
    model: &Model<'a, 'd, '_>,
    notes: &mut Notes,
) -> Result<Vec<ToCome<'a, 'd>>, ImportError> {
    let mut kept = Vec::new();
    for (node, frame, class) in bodies {
        let parts = Parts::read(node, class, model)?;
        let cut = parts.names().find(|name| model.options.cut.iter().any(|cut| cut == name));
        if let Some(name) = cut {
            notes.add_of(NoteKind::LeftOut, "bodies with all on them, by the user's word", name);
            continue;
        }
        let frame = Pose { position_m: frame.position_m - shift_m, ..frame };
        kept.push(ToCome { parts, parent: parent.map(str::to_owned), frame });
    }
    Ok(kept)
}

/// Places the base at its pose in the file.
fn stand(name: &str, floats: bool, pose: Pose, description: &mut Description, notes: &mut Notes) {
    imported::place_base(description, pose.position_m, pose.rotation);
    if floats {
        let text = format!(
            "`{name}` floats by a free joint: it is the base, which is fixed, as on a stand. To let the base move: \
             mount.base = \"driven\""
        );
        notes.add(NoteKind::Changed, text);
    }
}

/// Adds the joints of a body as a chain, because MuJoCo applies them one after the other. Bodies without mass
/// connect them. Returns the origin of the rig's body in the frame of the file's body: the position of the last
/// joint.
fn hang(
    name: &str,
    joints: Vec<MjcfJoint>,
    parent: String,
    pose: Pose,
    names: &mut Names,
    description: &mut Description,
    notes: &mut Notes,
) -> DVec3 {
    if joints.is_empty() {
        description.joints.push(Joint {
            name: Names::fresh(&mut names.joints, &format!("{name}_weld")),
            kind: JointType::Fixed,
            parent,
            child: name.to_owned(),
            position_m: pose.position_m.to_array(),
            rotation_xyzw: xml::tidy(pose.rotation).to_array(),
            ..Joint::default()
        });
        return DVec3::ZERO;
    }
    let last = joints.len() - 1;
    let (mut parent, mut frame, mut shift_m) = (parent, pose, DVec3::ZERO);
    for (place, MjcfJoint { joint, anchor_m, zero }) in joints.into_iter().enumerate() {
        let at_anchor = Pose { position_m: anchor_m - shift_m, ..Pose::IDENTITY };
        let placement = frame.then(at_anchor).then(zero);
        let child = if place == last {
            name.to_owned()
        } else {
            let between = Names::fresh(&mut names.bodies, &format!("{name}_{}", joint.name));
            let text = "bodies with several joints: a chain, with bodies without mass between";
            notes.add_of(NoteKind::Changed, text, &between);
            description.bodies.push(Mass::point(0.0).body(&between));
            between
        };
        description.joints.push(Joint {
            parent: parent.clone(),
            child: child.clone(),
            position_m: placement.position_m.to_array(),
            rotation_xyzw: xml::tidy(placement.rotation).to_array(),
            ..joint
        });
        (parent, frame, shift_m) = (child, Pose::IDENTITY, anchor_m);
    }
    shift_m
}

fn refuse_several_robots(root: Node<'_, '_>, top: &[ToCome<'_, '_>]) -> Result<(), ImportError> {
    let floats =
        |body: &&ToCome<'_, '_>| body.parts.joints.iter().any(|(joint, _)| joint::is_free(joint));
    let names: Vec<&str> =
        top.iter().filter(floats).map(|body| body.parts.name().unwrap_or_default()).collect();
    if names.len() < 2 {
        return Ok(());
    }
    let expected = "one body that moves freely, the robot; the option cut leaves others out";
    Err(xml::refuse(root, expected, format!("{}: {}", names.len(), list(&names))))
}

fn tell_quirks(body: Node<'_, '_>, name: &str, notes: &mut Notes) {
    if body.attribute("mocap") == Some("true") {
        let text = "is a target for motion capture, not a part of the robot; cut leaves it out";
        notes.add_of(NoteKind::Doubtful, text, name);
    }
    if body.attribute("gravcomp").is_some_and(|share| share.trim() != "0") {
        notes.add_of(NoteKind::LeftOut, "gravity that is compensated by itself (gravcomp)", name);
    }
}
