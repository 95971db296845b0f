//! Kinds of golden files.

use std::fmt;

use clap::ValueEnum;

/// The kind of a golden file: the part of its schema before the slash.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
#[value(rename_all = "snake_case")]
pub enum Kind {
    /// Inverse dynamics, mass matrix and kinematics.
    Rnea,
    /// Control, from state errors to torques.
    Control,
    /// State errors.
    Errors,
    /// Finite differences of poses.
    FiniteDifference,
    /// Importance of joints.
    Weights,
    /// Distances of poses.
    Hauberg,
    /// Mass properties of solids.
    Solids,
}

impl Kind {
    /// Returns the name that schemas and `--skip` use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rnea => "rnea",
            Self::Control => "control",
            Self::Errors => "errors",
            Self::FiniteDifference => "finite_difference",
            Self::Weights => "weights",
            Self::Hauberg => "hauberg",
            Self::Solids => "solids",
        }
    }

    pub(super) fn of_schema(schema: &str) -> Option<Self> {
        let name = schema.split('/').next()?;
        Self::value_variants().iter().copied().find(|kind| kind.name() == name)
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
