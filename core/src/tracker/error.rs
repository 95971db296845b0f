//! Why there is no tracker, or no torques.

use core::fmt;

use crate::control::GainsError;
use crate::controller::ControllerError;
use crate::coordinates::CoordinatesError;
use crate::importance::{ImportanceError, RestPoseError};
use crate::observer::ObserverError;
use crate::projection::ProjectionError;
use crate::state::StateInputError;
use crate::state_error::ReferencesError;

/// Why a frame or a reading was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum InputError {
    /// There must be one pose for each joint.
    Count {
        /// Number of joints.
        expected: usize,
        /// Number of poses.
        found: usize,
    },
    /// A pose.
    Pose(StateInputError),
    /// A pose that the projection cannot take.
    Projection(ProjectionError),
    /// Coordinates.
    Coordinates(CoordinatesError),
    /// A frame is of another kind than those that the tracker began with.
    Kind,
}

/// Refuses poses that are not one for each joint.
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

/// Why a tick has no torques.
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

/// Why a setting cannot be.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum SettingError {
    /// An observer of accelerations for a law that commands none.
    ObserverWithoutDynamics,
    /// Gains of joints for a law that knows their inertia itself.
    GainsWithoutPd,
    /// Gains of a period for a law that has no unit of inertia.
    ImplicitWithoutInertia,
    /// A value that [`MethodName::Recommended`](super::MethodName::Recommended) has of its own.
    Fixed {
        /// The key, dotted.
        key: &'static str,
    },
    /// A body that the rig does not have.
    Reference {
        /// Its number.
        body: usize,
        /// Number of bodies.
        bodies: usize,
    },
    /// A value out of its range.
    Value {
        /// The key, dotted.
        key: &'static str,
        /// The values that are accepted.
        expected: &'static str,
        /// The value that was found.
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

/// Why a tracker cannot be made.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum TrackerError {
    /// A setting cannot be.
    Setting(SettingError),
    /// The gains cannot be used.
    Gains(GainsError),
    /// The bodies that others are seen from cannot be.
    References(ReferencesError),
    /// The controller.
    Controller(ControllerError),
    /// The projection.
    Projection(ProjectionError),
    /// The observer.
    Observer(ObserverError),
    /// The rig's rest pose cannot be weighed.
    RestPose(RestPoseError),
    /// The rig's joints have no importance.
    Importance(ImportanceError),
    /// Ranges or weights for a method without a projection.
    NoProjection,
    /// The supply was made of another rig.
    SupplyJoints {
        /// Number of the rig's joints.
        expected: usize,
        /// Number of the supply's joints.
        found: usize,
    },
    /// The supply has weights that [`Settings::sharing`](super::Settings::sharing) has no use for, or lacks them.
    SupplyWeights,
    /// There is not a rest zone for each joint, or one is not a finite number from 0.
    Rest,
    /// With the method `recommended`, the latency and the tick together take longer than
    /// [`MAX_DELAY_S`](super::MAX_DELAY_S).
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
