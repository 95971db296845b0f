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
    /// Not the TOML of a setup.
    #[error("{0}")]
    Toml(String),
    /// A subject for a body that needs none.
    #[error("subject: expected with body = \"hanavan_kwon\" only")]
    SubjectWithoutBody,
    /// A setting of the figure that is made from a clip.
    #[error("{key}: expected to be left out, since the rig has its own")]
    OfTheFigure {
        /// The key.
        key: &'static str,
    },
    /// The reference is no body of the rig.
    #[error("controller.reference: expected a body of the rig ({names}), found `{found}`")]
    NoSuchBody {
        /// The bodies there are.
        names: String,
        /// The name that was given.
        found: String,
    },
    /// A setting of the controller.
    #[error("controller.{0}")]
    Controller(#[from] SettingError),
    /// A value out of its range.
    #[error("{key}: expected {expected}, found {value}")]
    Value {
        /// The key, dotted.
        key: String,
        /// The values that are accepted.
        expected: &'static str,
        /// The value that was found.
        value: f64,
    },
}

/// Why an evaluation has no result.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EvaluateError {
    /// Nothing to evaluate.
    #[error("there is no clip to evaluate")]
    NoClips,
    /// The setup cannot be.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// One run failed.
    #[error("clip {clip}, scale {scale}, method {method}: {kind}")]
    Run {
        /// The clip.
        clip: String,
        /// Factor on the figure's dimensions.
        scale: f64,
        /// The method.
        method: MethodName,
        /// Why.
        kind: RunError,
    },
}

impl EvaluateError {
    /// Whether a rig was lost, which is a result; anything else is bad input.
    pub fn is_loss(&self) -> bool {
        matches!(self, Self::Run { kind, .. } if kind.is_loss())
    }
}

/// Why a run failed.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RunError {
    /// Forward differences of second order need three frames.
    #[error("the clip has {frames} frames; at least 3 are needed")]
    TooShort {
        /// Frames of the clip.
        frames: usize,
    },
    /// Ticks are counted in 31 bits.
    #[error("{frames} frames; at most 2147483647 can be tracked")]
    TooLong {
        /// Frames of the clip.
        frames: usize,
    },
    /// The rig was lost.
    #[error("diverged at frame {frame}: the {body} is {linear_m:.3} m from its goal")]
    Diverged {
        /// Frame of the clip.
        frame: usize,
        /// The body farthest off, or the first whose pose is no number.
        body: String,
        /// How far, in metres.
        linear_m: f64,
    },
    /// The controller's arithmetic overflowed.
    #[error("frame {frame}: a torque is not finite")]
    TorqueNotFinite {
        /// Frame of the clip.
        frame: usize,
    },
    /// A desired or measured state is not one.
    #[error("frame {frame}: {source}")]
    State {
        /// Frame of the clip.
        frame: usize,
        /// Why.
        source: StepError,
    },
    /// The setup does not go with the rig.
    #[error(transparent)]
    Setup(#[from] SetupError),
    /// There is no such tracker.
    #[error("controller: {0}")]
    Tracker(#[from] TrackerError),
    /// The clip's skeleton cannot be given a body.
    #[error(transparent)]
    Model(#[from] BodyModelError),
    /// The figure cannot be built.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The limits of the drives cannot be.
    #[error(transparent)]
    Controller(#[from] ControllerError),
    /// The figure's rest pose cannot be weighed.
    #[error(transparent)]
    RestPose(#[from] RestPoseError),
    /// The figure's joints have no importance.
    #[error(transparent)]
    Importance(#[from] ImportanceError),
    /// There is no such supply.
    #[error(transparent)]
    Supply(#[from] SupplyError),
    /// The plant cannot be built.
    #[error(transparent)]
    Plant(#[from] PlantError),
}

impl RunError {
    /// Whether the rig was lost, which is a result; anything else is bad input.
    pub fn is_loss(&self) -> bool {
        matches!(self, Self::Diverged { .. } | Self::TorqueNotFinite { .. })
    }
}
