//! Errors of the weighting of joints.

use std::path::PathBuf;

use sinew_core::importance::{ImportanceError, RestPoseError, VertexError};

use super::limits::JOINT_COUNT_MAX;

/// The error of a character whose weights a method cannot compute.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A setting whose value is invalid.
    #[error("{name}: expected {expected}, found {found:?}")]
    Setting {
        /// Name of the option.
        name: &'static str,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found.
        found: f64,
    },
    /// A character with more joints than `core` supports.
    #[error("expected at most {JOINT_COUNT_MAX} joints, found {found}")]
    TooManyJoints {
        /// Number of joints.
        found: usize,
    },
    /// A character without a mesh, for the method that needs one.
    #[error("method mesh: expected a character with a skinned mesh, found a skeleton only")]
    NoMesh,
    /// A mesh without surface.
    #[error(
        "method mesh: expected a mesh with a surface, found {triangles} triangles without area"
    )]
    NoSurface {
        /// Number of triangles.
        triangles: usize,
    },
    /// A file of radii that cannot be read.
    #[error("{}: expected a CSV of radii: {source}", file.display())]
    RadiusFile {
        /// Path of the file.
        file: PathBuf,
        /// Fault and its place in the file.
        source: csv::Error,
    },
    /// A file without the necessary columns.
    #[error("{}:1: expected the columns joint and radius_m, found {found}", file.display())]
    RadiusColumns {
        /// Path of the file.
        file: PathBuf,
        /// Names of the file's columns.
        found: String,
    },
    /// An invalid row of a file of radii.
    #[error("{}:{line}: joint `{joint}`: expected {expected}, found {found}", file.display())]
    RadiusRow {
        /// Path of the file.
        file: PathBuf,
        /// Number of the line, from 1.
        line: u64,
        /// Joint of the row.
        joint: String,
        /// Description of a valid value.
        expected: String,
        /// Description of the value that was found.
        found: String,
    },
    /// A bone without a radius in the file.
    #[error(
        "{}: expected a radius of every bone that has a length, found none of joint `{joint}`{}",
        file.display(), if *more == 0 { String::new() } else { format!(" and {more} others") }
    )]
    RadiusMissing {
        /// Path of the file.
        file: PathBuf,
        /// First joint without a radius.
        joint: String,
        /// Number of further joints without a radius.
        more: usize,
    },
    /// A skeleton that `core` refuses.
    #[error(transparent)]
    RestPose(#[from] RestPoseError),
    /// Weights that `core` refuses.
    #[error(transparent)]
    Importance(#[from] ImportanceError),
    /// A vertex that `core` refuses.
    #[error("vertex {vertex}: {source}")]
    Vertex {
        /// Index of the vertex.
        vertex: usize,
        /// Reason for the refusal.
        source: VertexError,
    },
}
