//! Reads one joint of a URDF.

use std::collections::BTreeMap;

use glam::{DQuat, DVec3};
use roxmltree::Node;

use super::super::note::Notes;
use super::super::tie::Tie;
use super::super::{none, xml};
use super::limits;
use crate::description::{Joint, JointType};
use crate::import::error::ImportError;
use crate::import::note::NoteKind;

/// A joint, and the parts of it that are resolved after all joints are read.
pub(super) struct UrdfJoint<'a, 'd> {
    pub(super) node: Node<'a, 'd>,
    pub(super) name: &'a str,
    /// Indices in the list of links.
    pub(super) parent: usize,
    pub(super) child: usize,
    pub(super) joint: Joint,
    pub(super) mimic: Option<Mimic<'a, 'd>>,
}

/// A relation `q = multiplier · q[of] + offset`.
#[derive(Clone, Copy)]
pub(super) struct Mimic<'a, 'd> {
    pub(super) node: Node<'a, 'd>,
    pub(super) of: &'a str,
    pub(super) multiplier: f64,
    pub(super) offset: f64,
}

/// Maximum angle, rad. Larger angles are regarded as damage: f64 keeps few digits within a turn for them.
const ANGLE_MAX_RAD: f64 = 1e6;

impl Mimic<'_, '_> {
    /// Converts the relation to the form that both formats share.
    pub(super) fn tie(
        self,
        joint: &UrdfJoint<'_, '_>,
        in_file: &BTreeMap<&str, usize>,
    ) -> Result<Tie, ImportError> {
        if !in_file.contains_key(self.of) {
            return Err(xml::refuse_value(self.node, "joint", "a joint of the file"));
        }
        Ok(Tie {
            joint: joint.name.to_owned(),
            of: self.of.to_owned(),
            multiplier: self.multiplier,
            offset: self.offset,
        })
    }
}

impl<'a, 'd> UrdfJoint<'a, 'd> {
    pub(super) fn read(
        node: Node<'a, 'd>,
        links: &BTreeMap<&str, usize>,
        notes: &mut Notes,
    ) -> Result<Self, ImportError> {
        let name = xml::required(node, "name")?;
        let kind = kind(node, name, notes)?;
        let link = |tag| {
            let end = xml::child(node, tag)?
                .ok_or_else(|| xml::refuse(node, format!("an element `{tag}`"), "none"))?;
            let link = xml::required(end, "link")?;
            let place = links.get(link).copied();
            let place =
                place.ok_or_else(|| xml::refuse_value(end, "link", "a link of the file"))?;
            Ok::<_, ImportError>((link, place))
        };
        let ((parent, parent_place), (child, child_place)) = (link("parent")?, link("child")?);
        let (position, rotation) = origin(node)?;
        let mut joint = Joint {
            name: name.to_owned(),
            kind,
            parent: parent.to_owned(),
            child: child.to_owned(),
            position_m: position.to_array(),
            rotation_xyzw: rotation.to_array(),
            axis: axis(node, kind)?,
            ..Joint::default()
        };
        let is_driven = !matches!(kind, JointType::Fixed | JointType::Free);
        if let Some(dynamics) = xml::child(node, "dynamics")?.filter(|_| is_driven) {
            joint.damping = none::damping(dynamics, "damping", 1, name, notes)?;
            joint.friction = none::damping(dynamics, "friction", 1, name, notes)?;
        }
        limits::read(node, &mut joint, notes)?;
        let mimic = xml::child(node, "mimic")?.map(|mimic| read_mimic(mimic, name)).transpose()?;
        Ok(Self { node, name, parent: parent_place, child: child_place, joint, mimic })
    }
}

fn kind(node: Node<'_, '_>, name: &str, notes: &mut Notes) -> Result<JointType, ImportError> {
    Ok(match xml::required(node, "type")? {
        "revolute" => JointType::Revolute,
        "continuous" => {
            let text = "continuous joints turn without end: revolute ones without a range. A servo of less than a \
                        turn needs one";
            notes.add_of(NoteKind::Changed, text, name);
            JointType::Revolute
        }
        "prismatic" => JointType::Prismatic,
        "fixed" => JointType::Fixed,
        "floating" => JointType::Free,
        "spherical" => JointType::Spherical,
        "planar" => {
            let expected =
                "two prismatic joints and a revolute one, which a rig has instead of a planar one";
            return Err(xml::refuse_value(node, "type", expected));
        }
        _ => {
            let expected = "revolute, continuous, prismatic, fixed, floating or spherical";
            return Err(xml::refuse_value(node, "type", expected));
        }
    })
}

/// Reads the pose of an element's `origin`; the identity without that element.
pub(super) fn origin(node: Node<'_, '_>) -> Result<(DVec3, DQuat), ImportError> {
    let Some(origin) = xml::child(node, "origin")? else {
        return Ok((DVec3::ZERO, DQuat::IDENTITY));
    };
    let position = xml::vector(origin, "xyz")?.map_or(DVec3::ZERO, DVec3::from_array);
    let [roll, pitch, yaw] = xml::vector(origin, "rpy")?.unwrap_or_default();
    if [roll, pitch, yaw].iter().any(|angle| angle.abs() > ANGLE_MAX_RAD) {
        return Err(xml::refuse_value(origin, "rpy", "three angles of at most 1000000 rad"));
    }
    // Roll, pitch and yaw about the parent's fixed axes, in this order.
    let rotation =
        DQuat::from_rotation_z(yaw) * DQuat::from_rotation_y(pitch) * DQuat::from_rotation_x(roll);
    Ok((position, xml::tidy(rotation)))
}

/// Reads the unit axis of a joint that needs one. The axis of a fixed joint is not read, because it is often zero.
fn axis(node: Node<'_, '_>, kind: JointType) -> Result<Option<[f64; 3]>, ImportError> {
    if !matches!(kind, JointType::Revolute | JointType::Prismatic) {
        return Ok(None);
    }
    let Some(element) = xml::child(node, "axis")? else { return Ok(Some([1.0, 0.0, 0.0])) };
    let axis = xml::vector(element, "xyz")?.map_or(DVec3::X, DVec3::from_array);
    match axis.try_normalize() {
        Some(axis) => Ok(Some(axis.to_array())),
        None => Err(xml::refuse_value(element, "xyz", "an axis that is not zero")),
    }
}

fn read_mimic<'a, 'd>(node: Node<'a, 'd>, joint: &str) -> Result<Mimic<'a, 'd>, ImportError> {
    let of = xml::required(node, "joint")?;
    if of == joint {
        return Err(xml::refuse_value(node, "joint", "another joint"));
    }
    let multiplier = xml::number(node, "multiplier")?.unwrap_or(1.0);
    let offset = xml::number(node, "offset")?.unwrap_or(0.0);
    Ok(Mimic { node, of, multiplier, offset })
}
