//! Errors of a tracker: in its settings, and in the inputs of a tick.

use core::fmt;

use crate::control::GainsError;
use crate::controller::ControllerError;
use crate::coordinates::CoordinatesError;
use crate::importance::{ImportanceError, RestPoseError};
use crate::observer::ObserverError;
use crate::projection::ProjectionError;
use crate::state::StateInputError;
use crate::state_error::ReferencesError;

/// An error in a frame or a reading.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InputError {
    /// The number of poses is not the number of joints.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of poses.
        found: usize,
    },
    /// A pose is invalid.
    Pose(StateInputError),
    /// The projection refused a pose.
    Projection(ProjectionError),
    /// The coordinates are invalid.
    Coordinates(CoordinatesError),
    /// A frame is of another kind than the first frames.
    Kind,
}

/// Refuses poses unless there is exactly one for each joint.
pub(super) fn check_count(expected: usize, found: usize) -> Result<(), InputError> {
    if found == expected { Ok(()) } else { Err(InputError::Count { expected, found }) }
}

impl From<StateInputError> for InputError {
    fn from(error: StateInputError) -> Self {
        Self::Pose(error)
    }
}

impl From<ProjectionError> for InputError {
    fn from(error: ProjectionError) -> Self {
        Self::Projection(error)
    }
}

impl From<CoordinatesError> for InputError {
    fn from(error: CoordinatesError) -> Self {
        Self::Coordinates(error)
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "{expected} joints need as many poses, {found} were given")
            }
            Self::Pose(error) => error.fmt(f),
            Self::Projection(error) => error.fmt(f),
            Self::Coordinates(error) => error.fmt(f),
            Self::Kind => f.write_str(
                "the source changed between poses and coordinates; call `begin` before another kind of source",
            ),
        }
    }
}

impl core::error::Error for InputError {}

/// An error because of which a tick has no torques.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StepError {
    /// A frame of the performance was refused.
    Frame(InputError),
    /// The reading was refused.
    Measured(InputError),
}

impl fmt::Display for StepError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Frame(error) => write!(f, "a frame of the performance: {error}"),
            Self::Measured(error) => write!(f, "the measured joints: {error}"),
        }
    }
}

impl core::error::Error for StepError {}

/// An error in the settings of a tracker.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SettingError {
    /// An observer of accelerations is combined with a law that commands none.
    ObserverWithoutDynamics,
    /// Gains per joint are combined with a law that already includes the joints' inertia.
    GainsWithoutPd,
    /// Implicit gains are combined with a law whose gains are not per unit of inertia.
    ImplicitWithoutInertia,
    /// A value that [`MethodName::Recommended`](super::MethodName::Recommended) fixes was set to another value.
    Fixed {
        /// Key of the setting, with dots between its parts.
        key: &'static str,
    },
    /// The rig has no body with this index.
    Reference {
        /// Index of the body.
        body: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A value is out of its range.
    Value {
        /// Key of the setting, with dots between its parts.
        key: &'static str,
        /// Description of the accepted values.
        expected: &'static str,
        /// The invalid value.
        value: f32,
    },
}

impl fmt::Display for SettingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ObserverWithoutDynamics => f.write_str(
                "law: expected \"inverse_dynamics\" with an observer, such as that of the method \"recommended\"; \
                 found \"pd\"",
            ),
            Self::GainsWithoutPd => {
                f.write_str("gains: expected \"uniform\"; other gains need law = \"pd\"")
            }
            Self::ImplicitWithoutInertia => f.write_str(
                "implicit: expected false with uniform gains of law = \"pd\", which are not per unit of inertia",
            ),
            Self::Fixed { key } => write!(
                f,
                "{key}: fixed by method = \"recommended\"; use \"manifold_projection\" and set it"
            ),
            Self::Reference { body, bodies } => {
                write!(f, "reference: expected one of the rig's {bodies} bodies, found body {body}")
            }
            Self::Value { key, expected, value } => {
                write!(f, "{key}: expected {expected}, found {value}")
            }
        }
    }
}

impl core::error::Error for SettingError {}

/// An error in the settings of a tracker, or in their combination with a rig.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TrackerError {
    /// A setting is invalid.
    Setting(SettingError),
    /// The gains are invalid.
    Gains(GainsError),
    /// The reference bodies of the accumulated error are invalid.
    References(ReferencesError),
    /// The controller refused its settings.
    Controller(ControllerError),
    /// The projection refused its settings.
    Projection(ProjectionError),
    /// The observer refused its settings.
    Observer(ObserverError),
    /// The rig's rest pose is invalid, so its joints have no importance.
    RestPose(RestPoseError),
    /// The importance of the rig's joints is invalid.
    Importance(ImportanceError),
    /// Ranges or weights were set for a method without a projection.
    NoProjection,
    /// The supply is for another number of joints than the rig has.
    SupplyJoints {
        /// Number of the rig's joints.
        expected: usize,
        /// Number of the supply's joints.
        found: usize,
    },
    /// The supply has weights that [`Settings::sharing`](super::Settings::sharing) does not use, or lacks required
    /// weights.
    SupplyWeights,
    /// The number of radii of rest zones is not the number of joints, or a radius is not a finite number, zero or more.
    Rest,
    /// With the method `recommended`, the latency plus the tick exceed [`MAX_DELAY_S`](super::MAX_DELAY_S).
    TooLate,
}

macro_rules! from {
    ($($error:ident => $variant:ident),* $(,)?) => {
        $(impl From<$error> for TrackerError {
            fn from(error: $error) -> Self {
                Self::$variant(error)
            }
        })*
    };
}

from! {
    SettingError => Setting,
    GainsError => Gains,
    ReferencesError => References,
    ControllerError => Controller,
    ProjectionError => Projection,
    ObserverError => Observer,
    RestPoseError => RestPose,
    ImportanceError => Importance,
}

impl fmt::Display for TrackerError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Setting(error) => error.fmt(f),
            Self::Gains(error) => error.fmt(f),
            Self::References(error) => error.fmt(f),
            Self::Controller(error) => error.fmt(f),
            Self::Projection(error) => error.fmt(f),
            Self::Observer(error) => error.fmt(f),
            Self::RestPose(error) => error.fmt(f),
            Self::Importance(error) => error.fmt(f),
            Self::NoProjection => f.write_str(
                "ranges and weights are of a projection: use the method \"manifold_projection\" or \"recommended\"",
            ),
            Self::SupplyJoints { expected, found } => {
                write!(f, "the supply is of a rig of {found} joints, this one has {expected}")
            }
            Self::SupplyWeights => f.write_str(
                "the supply must have weights if sharing = \"importance\", and no weights otherwise",
            ),
            Self::Rest => f.write_str(
                "there must be a rest zone for each joint, each a finite number from 0",
            ),
            Self::TooLate => f.write_str(
                "with method = \"recommended\" the latency and the tick together must not take longer than 10 ms: \
                 choose a higher rate, or another method",
            ),
        }
    }
}

impl core::error::Error for TrackerError {}
