//! A rig in the form that a person writes: named parts in SI units. Angles are in radians here, and in degrees in
//! `rig.toml`, see [`crate::toml_file`].
//!
//! [`Description::check`] refuses invalid values and reports their path; [`Description::mechanism`] converts the
//! description to bodies and joints by index.

mod body;
mod check;
mod doubt;
mod drive;
mod error;
mod face_shape;
mod joint;
pub(crate) mod mass;
mod mechanism;
mod mount;
mod pulses;
mod servo;
mod shape;
mod unit;

pub use body::{Body, InertiaMatrix};
pub(crate) use check::is_possible;
pub use doubt::Doubt;
pub(crate) use drive::UnitKeys;
pub use drive::{Drive, DriveKind};
pub use error::{DescriptionError, Path, Step};
pub use face_shape::FaceShape;
pub use joint::{Joint, JointType, LinkedLimit};
pub use mount::{Base, Mount, Supply};
pub use pulses::Pulses;
pub use servo::{MotorFigures, Servo, ServoModel, SourcedValue};
pub use shape::{BodyShape, ShapeKind};
pub(crate) use unit::is_angle;

pub use crate::servo::{Address, SignalLoss};

/// A whole rig.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Description {
    /// Name of the rig.
    pub name: String,
    /// Position and orientation of the base.
    pub mount: Mount,
    /// Power supply of the servos, if known.
    pub supply: Option<Supply>,
    /// Bodies in any order; exactly one of them, the base, is not the child of a joint.
    pub bodies: Vec<Body>,
    /// Joints in any order, one for every body except the base.
    pub joints: Vec<Joint>,
    /// Limits that join two joints, such as those of an upper and a lower lid.
    pub limits: Vec<LinkedLimit>,
    /// Shapes of a face. Files of other programs move the joints by these shapes.
    pub face_shapes: Vec<FaceShape>,
    /// Drives, by which servos move the joints.
    pub drives: Vec<Drive>,
    /// Servos of the rig.
    pub servos: Vec<Servo>,
    /// Kinds of servo in addition to the built-in kinds, see [`ServoModel::built_in`].
    pub servo_models: Vec<ServoModel>,
}
