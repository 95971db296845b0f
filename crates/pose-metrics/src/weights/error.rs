//! Why joints were not weighed.

use std::path::PathBuf;

use sinew_core::importance::{ImportanceError, RestPoseError, VertexError};

use super::limits::JOINT_COUNT_MAX;

/// A character that cannot be weighed so.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting makes no sense.
    #[error("{name}: expected {expected}, found {found:?}")]
    Setting {
        /// The option.
        name: &'static str,
        /// The values that are accepted.
        expected: &'static str,
        /// The value that was found.
        found: f64,
    },
    /// More joints than `core` can weigh.
    #[error("expected at most {JOINT_COUNT_MAX} joints, found {found}")]
    TooManyJoints {
        /// How many there are.
        found: usize,
    },
    /// Nothing to weigh it by.
    #[error("method mesh: expected a character with a skinned mesh, found a skeleton only")]
    NoMesh,
    /// A mesh that weighs nothing.
    #[error(
        "method mesh: expected a mesh with a surface, found {triangles} triangles without area"
    )]
    NoSurface {
        /// How many triangles it has.
        triangles: usize,
    },
    /// A file of radii that cannot be read.
    #[error("{}: expected a CSV of radii: {source}", file.display())]
    RadiusFile {
        /// The file.
        file: PathBuf,
        /// What is wrong in it, and where.
        source: csv::Error,
    },
    /// A file of other numbers.
    #[error("{}:1: expected the columns joint and radius_m, found {found}", file.display())]
    RadiusColumns {
        /// The file.
        file: PathBuf,
        /// Its columns.
        found: String,
    },
    /// A row of a file of radii that cannot be used.
    #[error("{}:{line}: joint `{joint}`: expected {expected}, found {found}", file.display())]
    RadiusRow {
        /// The file.
        file: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The joint of the row.
        joint: String,
        /// What would be right.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A bone without a radius.
    #[error(
        "{}: expected a radius of every bone that has a length, found none of joint `{joint}`{}",
        file.display(), if *more == 0 { String::new() } else { format!(" and {more} others") }
    )]
    RadiusMissing {
        /// The file.
        file: PathBuf,
        /// The first joint.
        joint: String,
        /// How many more.
        more: usize,
    },
    /// `core` refuses the skeleton.
    #[error(transparent)]
    RestPose(#[from] RestPoseError),
    /// `core` refuses the weights.
    #[error(transparent)]
    Importance(#[from] ImportanceError),
    /// `core` refuses a vertex.
    #[error("vertex {vertex}: {source}")]
    Vertex {
        /// The vertex.
        vertex: usize,
        /// Why.
        source: VertexError,
    },
}
