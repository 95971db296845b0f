//! Columns of a table of joint coordinates: their names and units.

use std::fmt;

use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link};

/// The quantity that a coordinate measures.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// An angle.
    Angle,
    /// A position of a slide.
    Length,
    /// A number whose column has no unit: of a quaternion, or of the base's pose.
    Pure,
}

/// A unit in the header of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Unit {
    /// Degrees.
    Deg,
    /// Radians.
    Rad,
    /// Millimetres.
    Mm,
    /// Metres.
    M,
}

impl Unit {
    /// All units. `Mm` is before `M`, since the name of the first ends in that of the second.
    pub const ALL: [Self; 4] = [Self::Deg, Self::Rad, Self::Mm, Self::M];

    /// Returns the unit's name, which headers have after an underscore.
    pub fn name(self) -> &'static str {
        match self {
            Self::Deg => "deg",
            Self::Rad => "rad",
            Self::Mm => "mm",
            Self::M => "m",
        }
    }

    /// Returns the quantity that the unit measures.
    pub fn quantity(self) -> Quantity {
        match self {
            Self::Deg | Self::Rad => Quantity::Angle,
            Self::Mm | Self::M => Quantity::Length,
        }
    }

    /// Converts a number in this unit to rad or m.
    pub fn to_si(self, number: f64) -> f64 {
        match self {
            Self::Deg => number.to_radians(),
            Self::Mm => number / 1000.0,
            Self::Rad | Self::M => number,
        }
    }

    /// Converts rad or m to a number in this unit.
    pub fn of_si(self, value: f64) -> f64 {
        match self {
            Self::Deg => value.to_degrees(),
            Self::Mm => 1000.0 * value,
            Self::Rad | Self::M => value,
        }
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The units of columns without a unit in the header.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HeaderUnits {
    /// Degrees, and millimetres of slides.
    Degrees,
    /// Radians, and metres of slides.
    Si,
}

impl HeaderUnits {
    /// Returns the unit of a quantity; `None` for a number without a unit.
    pub fn of(self, quantity: Quantity) -> Option<Unit> {
        match (quantity, self) {
            (Quantity::Angle, Self::Degrees) => Some(Unit::Deg),
            (Quantity::Angle, Self::Si) => Some(Unit::Rad),
            (Quantity::Length, Self::Degrees) => Some(Unit::Mm),
            (Quantity::Length, Self::Si) => Some(Unit::M),
            (Quantity::Pure, _) => None,
        }
    }
}

/// A coordinate of a rig, as a column of a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Column {
    /// Name without the unit: the joint's name, and the part after it if the joint has several coordinates (`.0`,
    /// `.w`).
    pub(crate) name: String,
    /// Index of the body that the joint moves.
    pub(crate) body: usize,
    /// The quantity that the column measures.
    pub(crate) quantity: Quantity,
}

impl Column {
    /// Returns the name in a header that Sinew writes: with the unit, deg or mm.
    pub(crate) fn header(&self) -> String {
        match HeaderUnits::Degrees.of(self.quantity) {
            Some(unit) => format!("{}_{unit}", self.name),
            None => self.name.clone(),
        }
    }
}

/// Returns the columns of all joints in the order of the rig's coordinates. A driven base has the seven columns of
/// its pose.
pub(crate) fn columns(mechanism: &Mechanism) -> Vec<Column> {
    let of_body = |(body, link): (usize, &Link)| {
        let name = &link.joint_name;
        let parts = |parts: &[&str]| parts.iter().map(|part| format!("{name}.{part}")).collect();
        let (names, quantity): (Vec<String>, Quantity) = match link.joint {
            JointModel::Fixed => (vec![], Quantity::Pure),
            JointModel::Revolute(_) => (vec![name.clone()], Quantity::Angle),
            JointModel::Prismatic(_) => (vec![name.clone()], Quantity::Length),
            JointModel::Universal(_) => (parts(&["0", "1"]), Quantity::Angle),
            JointModel::Spherical => (parts(&["x", "y", "z", "w"]), Quantity::Pure),
            JointModel::Free => {
                let parts = ["x", "y", "z", "qw", "qx", "qy", "qz"];
                (parts.map(|part| format!("root_{part}")).to_vec(), Quantity::Pure)
            }
        };
        names.into_iter().map(move |name| Column { name, body, quantity })
    };
    mechanism.bodies.iter().enumerate().flat_map(of_body).collect()
}
