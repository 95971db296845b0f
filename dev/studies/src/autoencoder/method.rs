//! The five ways of training.

use serde::Serialize;

/// What a training's loss counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Differences of local rotations, all joints alike.
    Uniform,
    /// The same, and differences of global positions and rotations.
    ForwardKinematics,
    /// Local differences, weighted by the length of what hangs on a joint.
    Lengths,
    /// Local differences, weighted by the surface of cylinders around the bones that hang on a joint.
    Cylinders,
    /// Local differences, weighted by the skin that hangs on a joint.
    Mesh,
}

impl Method {
    /// All methods, as tables list them.
    pub const ALL: [Self; 5] =
        [Self::Uniform, Self::ForwardKinematics, Self::Lengths, Self::Cylinders, Self::Mesh];

    /// The method's key in JSON and in file names.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::ForwardKinematics => "forward_kinematics",
            Self::Lengths => "lengths",
            Self::Cylinders => "cylinders",
            Self::Mesh => "mesh",
        }
    }

    /// The method as tables and pictures name it.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::ForwardKinematics => "FK loss",
            Self::Lengths => "lengths",
            Self::Cylinders => "cylinders",
            Self::Mesh => "mesh",
        }
    }
}
