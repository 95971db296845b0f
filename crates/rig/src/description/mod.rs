//! A rig as a person writes it: named parts in SI units. Angles are in radians here, and in degrees in `rig.toml`,
//! see [`crate::toml_file`].
//!
//! [`Description::check`] refuses what cannot be, by the path of the value; [`Description::mechanism`] makes of it
//! bodies and joints by index.

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

pub use body::{Body, InertiaMatrix};
pub(crate) use check::is_possible;
pub(crate) use drive::UnitKeys;
pub use drive::{Drive, DriveKind};
pub use error::{DescriptionError, Path, Step};
pub use joint::{Joint, JointType, LinkedLimit};
pub use mount::{Base, Mount, Supply};
pub use servo::{MotorFigures, Servo, ServoModel, SourcedValue};
pub(crate) use unit::is_angle;

pub use crate::servo::{Address, SignalLoss};

/// A whole rig.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// What people call it.
    pub name: String,
    /// Where and how the base stands.
    pub mount: Mount,
    /// What feeds the servos, if it is known.
    pub supply: Option<Supply>,
    /// The bodies in any order; one of them, the base, is no joint's child.
    pub bodies: Vec<Body>,
    /// The joints in any order, one for every body but the base.
    pub joints: Vec<Joint>,
    /// Limits that join two joints, such as those of an upper and a lower lid.
    pub limits: Vec<LinkedLimit>,
    /// How servos move the joints.
    pub drives: Vec<Drive>,
    /// The servos.
    pub servos: Vec<Servo>,
    /// Kinds of servo beside the built-in ones, see [`ServoModel::built_in`].
    pub servo_models: Vec<ServoModel>,
}
