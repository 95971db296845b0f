//! The errors of setups, runs and evaluations.

use sinew_core::importance::{ImportanceError, RestPoseError};
use sinew_core::supply::SupplyError;
use sinew_core::tracker::{MethodName, SettingError, StepError, TrackerError};
use sinew_core::{ControllerError, TreeError};
use sinew_figure::BodyModelError;
use sinew_figure::plant::PlantError;
use thiserror::Error;

/// An invalid setup.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SetupError {
    /// A text that is not the TOML of a setup.
    #[error("{0}")]
    Toml(String),
    /// A subject for a body model that does not use it.
    #[error("subject: expected with body = \"hanavan_kwon\" only")]
    SubjectWithoutBody,
    /// A setting that applies only to the figure, which is made from a clip.
    #[error("{key}: expected to be left out, since the rig has its own")]
    OfTheFigure {
        /// Name of the key.
        key: &'static str,
    },
    /// A reference that is not a body of the rig.
    #[error("controller.reference: expected a body of the rig ({names}), found `{found}`")]
    NoSuchBody {
        /// Names of the rig's bodies.
        names: String,
        /// Name that was given.
        found: String,
    },
    /// An invalid setting of the controller.
    #[error("controller.{0}")]
    Controller(#[from] SettingError),
    /// A value outside its range.
    #[error("{key}: expected {expected}, found {value}")]
    Value {
        /// Name of the key, with dots.
        key: String,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found.
        value: f64,
    },
}

/// The error of an evaluation without a result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EvaluateError {
    /// An empty list of clips.
    #[error("there is no clip to evaluate")]
    NoClips,
    /// An invalid setup.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A run that failed.
    #[error("clip {clip}, scale {scale}, method {method}: {kind}")]
    Run {
        /// Name of the clip.
        clip: String,
        /// Factor on the figure's dimensions.
        scale: f64,
        /// Method of the run.
        method: MethodName,
        /// Reason for the failure.
        kind: RunError,
    },
}

impl EvaluateError {
    /// Returns whether the rig was lost, which is a result. Every other error is bad input.
    pub fn is_loss(&self) -> bool {
        matches!(self, Self::Run { kind, .. } if kind.is_loss())
    }
}

/// The error of a run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RunError {
    /// A clip that is too short: second-order forward differences need three frames.
    #[error("the clip has {frames} frames; at least 3 are needed")]
    TooShort {
        /// Number of frames in the clip.
        frames: usize,
    },
    /// A clip that is too long: ticks are counted in 31 bits.
    #[error("{frames} frames; at most 2147483647 can be tracked")]
    TooLong {
        /// Number of frames in the clip.
        frames: usize,
    },
    /// A rig that was lost.
    #[error("diverged at frame {frame}: the {body} is {linear_m:.3} m from its goal")]
    Diverged {
        /// Index of the clip's frame.
        frame: usize,
        /// Name of the body that is farthest from its goal, or the first body whose pose is not a number.
        body: String,
        /// Distance from its goal, in metres.
        linear_m: f64,
    },
    /// A torque that overflowed in the controller's arithmetic.
    #[error("frame {frame}: a torque is not finite")]
    TorqueNotFinite {
        /// Index of the clip's frame.
        frame: usize,
    },
    /// A desired or measured state that is invalid.
    #[error("frame {frame}: {source}")]
    State {
        /// Index of the clip's frame.
        frame: usize,
        /// Reason why the state is invalid.
        source: StepError,
    },
    /// A setup that does not fit the rig.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// A tracker that cannot be created.
    #[error("controller: {0}")]
    Tracker(#[from] TrackerError),
    /// A skeleton to which no body model fits.
    #[error(transparent)]
    Model(#[from] BodyModelError),
    /// A figure that cannot be built.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// Drive limits that are invalid.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// A rest pose for which weights cannot be computed.
    #[error(transparent)]
    RestPose(#[from] RestPoseError),
    /// A figure whose joints have no importance.
    #[error(transparent)]
    Importance(#[from] ImportanceError),
    /// An invalid supply.
    #[error(transparent)]
    Supply(#[from] SupplyError),
    /// A plant that cannot be built.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl RunError {
    /// Returns whether the rig was lost, which is a result. Every other error is bad input.
    pub fn is_loss(&self) -> bool {
        matches!(self, Self::Diverged { .. } | Self::TorqueNotFinite { .. })
    }
}
