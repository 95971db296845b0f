//! The rig that an importer makes: how it begins, and how it ends.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};

use super::error::ImportError;
use super::note::{Note, NoteKind, Notes};
use super::world::World;
use super::xml;
use crate::Description;
use crate::description::{JointType, Mount};

/// A rig, and what a person should know of how it came about.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The rig. It has no servos and no drives: these formats do not know them.
    pub description: Description,
    /// In the order of the file.
    pub notes: Vec<Note>,
    /// What was taken for its unit and for up.
    pub world: World,
}

/// A rig of nothing yet.
pub(super) fn empty(name: Option<&str>) -> Description {
    Description {
        name: name.filter(|name| !name.trim().is_empty()).unwrap_or("rig").to_owned(),
        mount: Mount::default(),
        supply: None,
        bodies: Vec::new(),
        joints: Vec::new(),
        limits: Vec::new(),
        drives: Vec::new(),
        servos: Vec::new(),
        servo_models: Vec::new(),
    }
}

/// Puts the base where the file has it, in a rig that stands.
pub(super) fn place_base(description: &mut Description, position_m: DVec3, rotation: DQuat) {
    let up = DQuat::from_array(description.mount.rotation_xyzw);
    // By right angles: so that what is on an axis stays on one.
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_quat(up);
    let turn = DMat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round());
    // Zero is added so that no -0 is written.
    description.mount.position_m = (turn * position_m).to_array().map(|x| x + 0.0);
    description.mount.rotation_xyzw = (up * rotation).normalize().to_array();
}

/// Bodies that move and weigh nothing, alone and with all that is welded to them.
pub(super) fn tell_massless(description: &Description, notes: &mut Notes) {
    let mut carried: BTreeMap<&str, f64> =
        description.bodies.iter().map(|body| (body.name.as_str(), body.mass_kg)).collect();
    // Joints are from the base outwards: inwards, a welded body's mass is complete before it is passed on.
    for joint in description.joints.iter().rev().filter(|joint| joint.kind == JointType::Fixed) {
        let mass_kg = carried.get(joint.child.as_str()).copied().unwrap_or_default();
        if let Some(on_parent) = carried.get_mut(joint.parent.as_str()) {
            *on_parent += mass_kg;
        }
    }
    for joint in description.joints.iter().filter(|joint| joint.kind != JointType::Fixed) {
        if carried.get(joint.child.as_str()).is_some_and(|mass_kg| *mass_kg <= 0.0) {
            let text = "moves and weighs nothing in the file: torques lack what it weighs in truth";
            notes.add_of(NoteKind::Doubtful, text, &joint.child);
        }
    }
}

/// The rig in metres, if it passes the check of all rigs: what a reader does not look at, that does.
pub(super) fn finish(
    root: roxmltree::Node<'_, '_>,
    world: World,
    mut description: Description,
    mut notes: Notes,
) -> Result<Imported, ImportError> {
    world.measure(&mut description, &mut notes);
    match description.check() {
        Ok(()) => Ok(Imported { description, notes: notes.finish(), world }),
        Err(error) => {
            let found = format!("{}, {} {}", error.found, error.path, error.item);
            Err(xml::refuse(root, error.expected, found))
        }
    }
}
