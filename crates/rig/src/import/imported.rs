//! The imported rig: its start values, and the final steps that both formats share.

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};

use super::error::ImportError;
use super::note::{Note, NoteKind, Notes};
use super::world::World;
use super::xml;
use crate::Description;
use crate::description::{JointType, Mount};

/// An imported rig, and what its user should know about the import.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// The rig. It has no servos and no drives, because the formats do not contain them.
    pub description: Description,
    /// Notes on the import, in the order of the file.
    pub notes: Vec<Note>,
    /// Unit of length and up direction that were assumed.
    pub world: World,
}

/// Creates a rig without bodies and joints.
pub(super) fn empty(name: Option<&str>) -> Description {
    Description {
        name: name.filter(|name| !name.trim().is_empty()).unwrap_or("rig").to_owned(),
        mount: Mount::default(),
        supply: None,
        bodies: Vec::new(),
        joints: Vec::new(),
        limits: Vec::new(),
        face_shapes: Vec::new(),
        drives: Vec::new(),
        servos: Vec::new(),
        servo_models: Vec::new(),
    }
}

/// Places the base at the file's pose, in the world of the rig.
pub(super) fn place_base(description: &mut Description, position_m: DVec3, rotation: DQuat) {
    let up = DQuat::from_array(description.mount.rotation_xyzw);
    // Rounds the axes to multiples of 90 deg, so that a position on an axis stays exactly on an axis.
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_quat(up);
    let turn = DMat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round());
    // Adding zero converts -0 to 0.
    description.mount.position_m = (turn * position_m).to_array().map(|x| x + 0.0);
    description.mount.rotation_xyzw = (up * rotation).normalize().to_array();
}

/// Adds notes on bodies that move although neither they nor the bodies welded to them have mass.
pub(super) fn tell_massless(description: &Description, notes: &mut Notes) {
    let mut carried: BTreeMap<&str, f64> =
        description.bodies.iter().map(|body| (body.name.as_str(), body.mass_kg)).collect();
    // Joints are sorted from the base outwards. In reverse order, a welded body's mass is complete before it is
    // added to its parent.
    for joint in description.joints.iter().rev().filter(|joint| joint.kind == JointType::Fixed) {
        let mass_kg = carried.get(joint.child.as_str()).copied().unwrap_or_default();
        if let Some(on_parent) = carried.get_mut(joint.parent.as_str()) {
            *on_parent += mass_kg;
        }
    }
    for joint in description.joints.iter().filter(|joint| joint.kind != JointType::Fixed) {
        if carried.get(joint.child.as_str()).is_some_and(|mass_kg| *mass_kg <= 0.0) {
            let text = "moves, but has no mass in the file: torques do not include its real weight";
            notes.add_of(NoteKind::Doubtful, text, &joint.child);
        }
    }
}

/// Converts lengths to metres, and applies the general check of rigs, which covers everything the readers do not
/// check.
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
