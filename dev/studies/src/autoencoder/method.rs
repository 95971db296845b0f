//! The five methods of training.

use serde::Serialize;

/// Differences that a training's loss counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Differences of local rotations, with equal weights of all joints.
    Uniform,
    /// Differences of local rotations, and of global positions and rotations.
    ForwardKinematics,
    /// Local differences, weighted by the length of the bones beyond a joint.
    Lengths,
    /// Local differences, weighted by the surface of cylinders around the bones beyond a joint.
    Cylinders,
    /// Local differences, weighted by the skin that a joint moves.
    Mesh,
}

impl Method {
    /// All methods, in the order of tables.
    pub const ALL: [Self; 5] =
        [Self::Uniform, Self::ForwardKinematics, Self::Lengths, Self::Cylinders, Self::Mesh];

    /// Returns the method's key in JSON and in file names.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Uniform => "uniform",
            Self::ForwardKinematics => "forward_kinematics",
            Self::Lengths => "lengths",
            Self::Cylinders => "cylinders",
            Self::Mesh => "mesh",
        }
    }

    /// Returns the method's name in tables and pictures.
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
