//! Robots of other programs as rigs: URDF (ROS) and MJCF (MuJoCo).
//!
//! What was changed, filled, left out or is doubtful is told in [`Imported::notes`], in words. What cannot be imported
//! is refused by line, column and name.

mod error;
mod mass;
mod mjcf;
mod note;
mod solid;
mod tie;
mod urdf;
mod world;
mod xml;

pub use error::{ImportError, Place};
pub use note::{Note, NoteKind};
pub use world::World;
pub use xml::document;

use std::collections::BTreeMap;

use glam::{DMat3, DQuat, DVec3};

use note::Notes;

use crate::Description;
use crate::description::{JointType, Mount};

/// The user's word on what a file leaves open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Joints to leave out, by name, and with them all that then hangs on nothing; of an MJCF, bodies too.
    pub cut: Vec<String>,
    /// Takes a mechanism with closed loops as the tree that the file holds: the loops stay open.
    pub open_loops: bool,
    /// Replaces inertia that no body can have by that of a ball with the same sum of principal moments (what MuJoCo's
    /// `balanceinertia` does), and inertia that neither the file nor a solid gives by that of a point.
    pub repair_inertia: bool,
    /// Length of the file's unit, m. Default: what an MJCF's gravity says, else 1. Masses, efforts, friction and
    /// damping are in SI units whatever it is.
    pub metres_per_unit: Option<f64>,
    /// The axis of the file that points up, unit. Default: against an MJCF's gravity, else z.
    pub up: Option<DVec3>,
}

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

/// Reads a URDF (the Unified Robot Description Format of ROS).
///
/// Every link is a body, and every joint a joint; welded ones too. A joint that mimics another stays a joint, and a
/// [`LinkedLimit`](crate::description::LinkedLimit) with equal ends ties it to the other.
///
/// # Errors
/// [`ImportError`] if the text is no XML or no robot, if its links are no tree, or a value cannot be.
///
/// ```
/// let text = r#"<robot name="nod">
///   <link name="stand"/>
///   <link name="head">
///     <inertial><mass value="0.2"/><inertia ixx="1e-4" iyy="1e-4" izz="1e-4" ixy="0" ixz="0" iyz="0"/></inertial>
///   </link>
///   <joint name="neck" type="revolute">
///     <parent link="stand"/><child link="head"/><axis xyz="0 1 0"/>
///     <limit lower="-0.5" upper="0.5" effort="0.4" velocity="6"/>
///   </joint>
/// </robot>"#;
/// let imported = sinew_rig::import::urdf(text, &Default::default())?;
/// let neck = &imported.description.joints[0];
/// assert_eq!((neck.axis, neck.effort), (Some([0.0, 1.0, 0.0]), Some(0.4)));
/// # Ok::<(), sinew_rig::import::ImportError>(())
/// ```
pub fn urdf(text: &str, options: &Options) -> Result<Imported, ImportError> {
    urdf::read(text, options)
}

/// Reads an MJCF (the format of MuJoCo).
///
/// Every body is a body; one with several joints is a chain, with bodies without mass between. The body at the top is
/// the base. What rotors add (`armature`) is each joint's rotor inertia, the largest forces of its actuators are its
/// effort, and an equality of two joints ties them as in [`urdf`].
///
/// # Errors
/// [`ImportError`] if the text is no XML or no model, has parts in other files, closed loops, or a value cannot be.
///
/// ```
/// let text = r#"<mujoco model="nod"><worldbody><body name="stand"><body name="head">
///   <joint name="neck" axis="0 1 0" range="-30 30" armature="0.01"/>
///   <geom type="box" size="0.03 0.02 0.04" pos="0 0 0.05"/>
/// </body></body></worldbody></mujoco>"#;
/// let imported = sinew_rig::import::mjcf(text, &Default::default())?;
/// let neck = &imported.description.joints[0];
/// assert_eq!((neck.axis, neck.rotor_inertia), (Some([0.0, 1.0, 0.0]), Some(0.01)));
/// # Ok::<(), sinew_rig::import::ImportError>(())
/// ```
pub fn mjcf(text: &str, options: &Options) -> Result<Imported, ImportError> {
    mjcf::read(text, options)
}

/// A rig of nothing yet.
fn empty(name: Option<&str>) -> Description {
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
fn place_base(description: &mut Description, position_m: DVec3, rotation: DQuat) {
    let up = DQuat::from_array(description.mount.rotation_xyzw);
    // By right angles: so that what is on an axis stays on one.
    let DMat3 { x_axis, y_axis, z_axis } = DMat3::from_quat(up);
    let turn = DMat3::from_cols(x_axis.round(), y_axis.round(), z_axis.round());
    // Zero is added so that no -0 is written.
    description.mount.position_m = (turn * position_m).to_array().map(|x| x + 0.0);
    description.mount.rotation_xyzw = (up * rotation).normalize().to_array();
}

/// Bodies that move and weigh nothing, alone and with all that is welded to them.
fn tell_massless(description: &Description, notes: &mut Notes) {
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
fn finish(
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
