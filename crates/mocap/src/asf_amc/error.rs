//! The reason why an AMC motion or its ASF skeleton was refused.

use std::path::PathBuf;

use crate::text::Position;

/// The reason why an AMC file, or its ASF file, cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system reported an error.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The skeleton file of the motion was not found.
    #[error(
        "{}: expected its skeleton in the same folder ({}, or the only *.asf there), found {found} *.asf files, none \
         with such a name",
        file.display(), expected.join(" or ")
    )]
    NoSkeleton {
        /// Path of the AMC file.
        file: PathBuf,
        /// Names that the skeleton file may have.
        expected: Vec<String>,
        /// Number of ASF files in the folder.
        found: usize,
    },
    /// The text is not valid in its format.
    #[error("{}:{}:{}: {problem}", file.display(), at.line, at.column)]
    Syntax {
        /// Path of the file.
        file: PathBuf,
        /// Position where reading stopped.
        at: Position,
        /// Error at that position.
        problem: Problem,
    },
}

/// The error at a position of an ASF or AMC file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A word does not fit the format.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// Description of the expected words.
        expected: String,
        /// Word that was found.
        found: String,
    },
    /// A required key of a bone is missing.
    #[error("bone `{bone}`: expected `{key}` before its `end`, found none")]
    Missing {
        /// Name of the bone.
        bone: String,
        /// Missing key.
        key: &'static str,
    },
    /// A name is used twice.
    #[error("expected another {item}, found a second `{name}`; the first is in line {first_line}")]
    Duplicate {
        /// Kind of item with the name.
        item: &'static str,
        /// Name that is used twice.
        name: String,
        /// Line of the first use.
        first_line: usize,
    },
    /// A dof changes the skeleton, such as a translation.
    #[error(
        "bone `{bone}`: expected rx, ry or rz, found `{found}`: bones that move or stretch are not \
         supported"
    )]
    NotRotation {
        /// Name of the bone.
        bone: String,
        /// Name of the dof.
        found: String,
    },
    /// The bone is missing in the hierarchy.
    #[error("bone `{bone}`: expected a place below `root` in the hierarchy, found none")]
    NotInHierarchy {
        /// Name of the bone.
        bone: String,
    },
    /// A bone has a length but no direction.
    #[error("bone `{bone}`: expected a direction for its length of {length}, found 0 0 0")]
    NoDirection {
        /// Name of the bone.
        bone: String,
        /// Length as written in the file.
        length: String,
    },
    /// There are more items than a figure's motion can need.
    #[error("expected at most {limit} {items}, found more")]
    TooMany {
        /// Kind of items.
        items: &'static str,
        /// Maximum number of items.
        limit: usize,
    },
    /// The frame numbers do not rise, or skip too many frames.
    #[error("expected a frame number from {least} to {most} after frame {last}, found {found}")]
    FrameNumber {
        /// Number of the last frame.
        last: u64,
        /// Smallest valid next number.
        least: u64,
        /// Largest valid next number.
        most: u64,
        /// Number that was found.
        found: u64,
    },
    /// A bone has another number of angles than dofs.
    #[error("frame {frame}, bone `{bone}`: expected {expected}, found {found}")]
    Values {
        /// Number of the frame.
        frame: u64,
        /// Name of the bone.
        bone: String,
        /// Expected number and kind of values.
        expected: String,
        /// Number of values that were found.
        found: usize,
    },
}
