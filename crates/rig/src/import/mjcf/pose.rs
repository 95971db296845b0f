//! Reads poses. MJCF has five ways to write a rotation.

use glam::{DMat3, DQuat, DVec3};
use roxmltree::Node;

use super::super::xml;
use super::defaults::Element;
use crate::import::error::ImportError;

/// Pose of a frame in another frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pose {
    pub(super) position_m: DVec3,
    pub(super) rotation: DQuat,
}

impl Pose {
    pub(super) const IDENTITY: Self = Self { position_m: DVec3::ZERO, rotation: DQuat::IDENTITY };

    /// Returns the pose of a frame that has pose `inner` in this frame.
    pub(super) fn then(self, inner: Self) -> Self {
        Self {
            position_m: self.position_m + self.rotation * inner.position_m,
            rotation: (self.rotation * inner.rotation).normalize(),
        }
    }
}

/// Rules by which the file writes angles.
#[derive(Debug, Clone, Copy)]
pub(super) struct Angles {
    /// Size of the file's angle unit, rad.
    unit_rad: f64,
    /// Axes of `euler`; true if an axis turns with the previous rotations.
    sequence: [(DVec3, bool); 3],
}

/// Maximum angle, rad. Larger angles are regarded as damage: f64 keeps few digits within a turn for them.
const ANGLE_MAX_RAD: f64 = 1e6;

impl Angles {
    pub(super) fn read(compilers: &[Node<'_, '_>]) -> Result<Self, ImportError> {
        let with = |name: &str| compilers.iter().find(|node| node.has_attribute(name));
        let unit_rad = match with("angle").map(|node| (node, node.attribute("angle"))) {
            None | Some((_, Some("degree"))) => 1_f64.to_radians(),
            Some((_, Some("radian"))) => 1.0,
            Some((node, _)) => return Err(xml::refuse_value(*node, "angle", "degree or radian")),
        };
        if let Some(node) =
            with("coordinate").filter(|node| node.attribute("coordinate") != Some("local"))
        {
            let expected = "local: MuJoCo itself has no other coordinates since version 2.3.4";
            return Err(xml::refuse_value(*node, "coordinate", expected));
        }
        let mut sequence = [(DVec3::X, true), (DVec3::Y, true), (DVec3::Z, true)];
        if let Some(node) = with("eulerseq") {
            let text = node.attribute("eulerseq").unwrap_or_default();
            let wrong = || {
                let expected =
                    "three of x, y, z (axes that turn along) or X, Y, Z (axes that stay)";
                xml::refuse_value(*node, "eulerseq", expected)
            };
            let letters: Vec<char> = text.trim().chars().collect();
            let letters = <[char; 3]>::try_from(letters).map_err(|_| wrong())?;
            for (slot, letter) in sequence.iter_mut().zip(letters) {
                let axis = match letter.to_ascii_lowercase() {
                    'x' => DVec3::X,
                    'y' => DVec3::Y,
                    'z' => DVec3::Z,
                    _ => return Err(wrong()),
                };
                *slot = (axis, letter.is_ascii_lowercase());
            }
        }
        Ok(Self { unit_rad, sequence })
    }

    /// Converts an angle of the file to rad.
    pub(super) fn rad(self, angle: f64) -> f64 {
        angle * self.unit_rad
    }

    /// Reads the pose of an element without defaults.
    pub(super) fn pose(self, node: Node<'_, '_>) -> Result<Pose, ImportError> {
        let position_m = xml::vector(node, "pos")?.map_or(DVec3::ZERO, DVec3::from_array);
        Ok(Pose { position_m, rotation: self.rotation(node)? })
    }

    /// Reads the pose of an element, including its defaults.
    pub(super) fn pose_of(self, element: &Element<'_, '_>) -> Result<Pose, ImportError> {
        let position_m = element.vector("pos")?.map_or(DVec3::ZERO, DVec3::from_array);
        Ok(Pose { position_m, rotation: self.rotation(element.at_any(&WAYS))? })
    }

    fn rotation(self, node: Node<'_, '_>) -> Result<DQuat, ImportError> {
        let ways: Vec<&str> = WAYS.into_iter().filter(|way| node.has_attribute(*way)).collect();
        let way = match *ways.as_slice() {
            [] => return Ok(DQuat::IDENTITY),
            [way] => way,
            [_, second, ..] => {
                return Err(xml::refuse_value(
                    node,
                    second,
                    "one way to say the rotation, not two",
                ));
            }
        };
        let not_zero =
            || xml::refuse_value(node, way, "a rotation that vectors of length zero do not give");
        let rotation = match way {
            "quat" => {
                let [w, x, y, z] = xml::vector(node, way)?.unwrap_or_default();
                let quat = DQuat::from_xyzw(x, y, z, w);
                if quat.length_squared() < 1e-12 { None } else { Some(quat.normalize()) }
            }
            "axisangle" => {
                let [x, y, z, angle] = xml::vector(node, way)?.unwrap_or_default();
                let axis = DVec3::new(x, y, z).try_normalize();
                let angle = self.checked(node, way, angle)?;
                axis.map(|axis| DQuat::from_axis_angle(axis, angle))
            }
            "euler" => {
                let angles: [f64; 3] = xml::vector(node, way)?.unwrap_or_default();
                let mut rotation = DQuat::IDENTITY;
                for ((axis, turns_along), angle) in self.sequence.into_iter().zip(angles) {
                    let turn = DQuat::from_axis_angle(axis, self.checked(node, way, angle)?);
                    rotation = if turns_along { rotation * turn } else { turn * rotation };
                }
                Some(rotation)
            }
            "xyaxes" => {
                let [a, b, c, d, e, f] = xml::vector(node, way)?.unwrap_or_default();
                let x = DVec3::new(a, b, c).try_normalize().ok_or_else(not_zero)?;
                let y = DVec3::new(d, e, f).reject_from_normalized(x).try_normalize();
                y.map(|y| DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y))))
            }
            _ => {
                let [x, y, z] = xml::vector(node, way)?.unwrap_or_default();
                let z_axis = DVec3::new(x, y, z).try_normalize();
                z_axis.map(|z_axis| DQuat::from_rotation_arc(DVec3::Z, z_axis))
            }
        };
        rotation.map(xml::tidy).ok_or_else(not_zero)
    }

    fn checked(self, node: Node<'_, '_>, way: &str, angle: f64) -> Result<f64, ImportError> {
        let rad = self.rad(angle);
        if rad.abs() <= ANGLE_MAX_RAD {
            Ok(rad)
        } else {
            Err(xml::refuse_value(node, way, "angles of at most 1000000 rad"))
        }
    }
}

/// Attributes that give a rotation.
const WAYS: [&str; 5] = ["quat", "axisangle", "euler", "xyaxes", "zaxis"];
