//! Joints, and limits that join two of them.

use serde::{Deserialize, Serialize};

use super::angle::{degree_pairs, degrees};

/// What a joint leaves free.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum JointType {
    /// Nothing. Such joints are merged when the tree is made, see [`super::Description::mechanism`].
    Fixed,
    /// A turn about `axis`.
    #[default]
    Revolute,
    /// A slide along `axis`.
    Prismatic,
    /// A turn about `axis`, fixed in the joint frame, then about `second_axis`, fixed in the body.
    Universal,
    /// Any turn.
    Spherical,
    /// Any motion.
    Free,
}

impl JointType {
    /// How many numbers make its speed.
    pub fn degrees_of_freedom(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute | Self::Prismatic => 1,
            Self::Universal => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }
}

/// A joint: how a body moves on its parent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Joint {
    /// What people call it; unique among joints.
    pub name: String,
    /// What it leaves free. Default: revolute.
    #[serde(rename = "type", default)]
    pub kind: JointType,
    /// The body that it hangs on.
    pub parent: String,
    /// The body that it moves.
    pub child: String,
    /// Where the joint is in the parent's frame, m.
    #[serde(default)]
    pub position_m: [f64; 3],
    /// Rotation of the joint frame in the parent's frame, unit quaternion x y z w.
    #[serde(default = "identity", skip_serializing_if = "is_identity")]
    pub rotation_xyzw: [f64; 4],
    /// Unit axis in the joint frame; of revolute, prismatic and universal joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub axis: Option<[f64; 3]>,
    /// Unit axis in the body frame, perpendicular to `axis`; of universal joints.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub second_axis: Option<[f64; 3]>,
    /// Least and most angle of each axis: one pair for a revolute joint, two for a universal one; for a spherical one a
    /// pair `[0, most]` for the angle away from its zero pose. Empty: no limit.
    #[serde(
        rename = "range_deg",
        with = "degree_pairs",
        default,
        skip_serializing_if = "Vec::is_empty"
    )]
    pub range_rad: Vec<[f64; 2]>,
    /// Least and most way of a prismatic joint, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range_m: Option<[f64; 2]>,
    /// Position in the home pose, of a revolute joint. Default: zero, or the end of the range that is nearest to it.
    #[serde(
        rename = "home_deg",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub home_rad: Option<f64>,
    /// The same of a prismatic joint, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home_m: Option<f64>,
    /// The largest speed that is asked for: of a turn.
    #[serde(
        rename = "speed_deg_s",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub speed_rad_s: Option<f64>,
    /// The same of a slide, m/s.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<f64>,
    /// The largest acceleration that is asked for: of a turn.
    #[serde(
        rename = "acceleration_deg_s2",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub acceleration_rad_s2: Option<f64>,
    /// The same of a slide, m/s².
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub acceleration_m_s2: Option<f64>,
    /// The largest torque (N m) or force (N) that the joint is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort: Option<f64>,
    /// What the drive's rotor adds to the inertia of each freedom, as its gear shows it: kg m², or kg of a slide.
    /// Default: that of the servos which move the joint.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rotor_inertia: Option<f64>,
    /// Coulomb friction: N m, or N of a slide.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub friction: f64,
    /// Viscous friction: N m s, or N s/m of a slide.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub damping: f64,
}

impl Default for Joint {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: JointType::Revolute,
            parent: String::new(),
            child: String::new(),
            position_m: [0.0; 3],
            rotation_xyzw: identity(),
            axis: None,
            second_axis: None,
            range_rad: Vec::new(),
            range_m: None,
            home_rad: None,
            home_m: None,
            speed_rad_s: None,
            speed_m_s: None,
            acceleration_rad_s2: None,
            acceleration_m_s2: None,
            effort: None,
            rotor_inertia: None,
            friction: 0.0,
            damping: 0.0,
        }
    }
}

impl Joint {
    /// Its coordinates in the home pose, as `q` of `sinew-core` has them. Turns and slides that say nothing are at
    /// zero, or at the end of the range that is nearest to it.
    pub fn home(&self) -> Vec<f64> {
        let nearest_to_zero = |range: Option<[f64; 2]>| {
            range.map_or(0.0, |[least, most]| 0.0_f64.max(least).min(most))
        };
        let range_rad = |axis: usize| self.range_rad.get(axis).copied();
        match self.kind {
            JointType::Fixed => Vec::new(),
            JointType::Revolute => {
                vec![self.home_rad.unwrap_or_else(|| nearest_to_zero(range_rad(0)))]
            }
            JointType::Prismatic => {
                vec![self.home_m.unwrap_or_else(|| nearest_to_zero(self.range_m))]
            }
            JointType::Universal => {
                vec![nearest_to_zero(range_rad(0)), nearest_to_zero(range_rad(1))]
            }
            JointType::Spherical => vec![0.0, 0.0, 0.0, 1.0],
            JointType::Free => vec![0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0],
        }
    }
}

/// A limit on the sum of two joints' positions: `least <= of · q[joint] + other_of · q[other] <= most`.
///
/// For two lids that must not meet: `1 · upper - 1 · lower >= 0`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkedLimit {
    /// A joint of one freedom.
    pub joint: String,
    /// Another one.
    pub other: String,
    /// Factor of the first.
    #[serde(default = "one")]
    pub factor: f64,
    /// Factor of the second.
    #[serde(default = "minus_one")]
    pub other_factor: f64,
    /// Least sum, in degrees in the file (m for slides: then `least_m`).
    #[serde(
        rename = "least_deg",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub least_rad: Option<f64>,
    /// Most.
    #[serde(
        rename = "most_deg",
        with = "degrees",
        default,
        skip_serializing_if = "Option::is_none"
    )]
    pub most_rad: Option<f64>,
    /// Least sum of two slides, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_m: Option<f64>,
    /// Most.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub most_m: Option<f64>,
}

fn identity() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

#[expect(clippy::float_cmp, reason = "exactly the default")]
fn is_identity(rotation: &[f64; 4]) -> bool {
    *rotation == identity()
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde asks for it")]
fn is_zero(number: &f64) -> bool {
    number.abs() <= 0.0
}

fn one() -> f64 {
    1.0
}

fn minus_one() -> f64 {
    -1.0
}
