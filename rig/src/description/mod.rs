//! A rig as a person writes it: named parts in SI units. The schema of `rig.toml`; angles are in degrees in the file
//! and in radians here.
//!
//! [`Description::check`] refuses what cannot be, by the path of the value; [`Description::mechanism`] makes of it
//! bodies and joints by index.

mod angle;
mod body;
mod check;
mod drive;
mod error;
mod joint;
pub(crate) mod mass;
mod mechanism;
mod mount;
mod servo;
mod unit;

use serde::{Deserialize, Serialize};

pub use body::{Body, InertiaMatrix};
pub(crate) use check::is_possible;
pub use drive::{Drive, DriveKind};
pub use error::{DescriptionError, Path, Step};
pub use joint::{Joint, JointType, LinkedLimit};
pub use mount::{Base, Mount, Supply};
pub use servo::{Address, Servo, ServoModel, SignalLoss, Sourced};

/// A whole rig.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Description {
    /// What people call it.
    pub name: String,
    /// Where and how the base stands.
    #[serde(default)]
    pub mount: Mount,
    /// What feeds the servos, if it is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub supply: Option<Supply>,
    /// The bodies in any order; one of them, the base, is no joint's child.
    #[serde(rename = "body")]
    pub bodies: Vec<Body>,
    /// The joints in any order, one for every body but the base.
    #[serde(rename = "joint", default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<Joint>,
    /// Limits that join two joints, such as those of an upper and a lower lid.
    #[serde(rename = "limit", default, skip_serializing_if = "Vec::is_empty")]
    pub limits: Vec<LinkedLimit>,
    /// How servos move the joints.
    #[serde(rename = "drive", default, skip_serializing_if = "Vec::is_empty")]
    pub drives: Vec<Drive>,
    /// The servos.
    #[serde(rename = "servo", default, skip_serializing_if = "Vec::is_empty")]
    pub servos: Vec<Servo>,
    /// Kinds of servo beside the built-in ones, see [`ServoModel::built_in`].
    #[serde(rename = "servo_model", default, skip_serializing_if = "Vec::is_empty")]
    pub servo_models: Vec<ServoModel>,
}
