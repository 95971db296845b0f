//! Why an AMC motion or its ASF skeleton was refused.

use std::path::PathBuf;

use crate::text::Position;

/// An AMC file, or its ASF file, that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system refused.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// The motion's skeleton is not there.
    #[error(
        "{}: expected its skeleton in the same folder ({}, or the only *.asf there), found {found} \
         *.asf files, none so named",
        file.display(), expected.join(" or ")
    )]
    NoSkeleton {
        /// The AMC file.
        file: PathBuf,
        /// Names that would do.
        expected: Vec<String>,
        /// ASF files in the folder.
        found: usize,
    },
    /// The text is not what its name says.
    #[error("{}:{}:{}: {problem}", file.display(), at.line, at.column)]
    Syntax {
        /// The file.
        file: PathBuf,
        /// Where reading stopped.
        at: Position,
        /// What is wrong there.
        problem: Problem,
    },
}

/// What is wrong at a place of an ASF or AMC file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// A word other than the format asks for.
    #[error("expected {expected}, found {found}")]
    Unexpected {
        /// What may stand here.
        expected: String,
        /// What stands here.
        found: String,
    },
    /// A bone lacks what it needs.
    #[error("bone `{bone}`: expected `{key}` before its `end`, found none")]
    Missing {
        /// The bone.
        bone: String,
        /// The key.
        key: &'static str,
    },
    /// A name that is already taken.
    #[error("expected another {item}, found a second `{name}`; the first is in line {first_line}")]
    Duplicate {
        /// What has the name.
        item: &'static str,
        /// The name.
        name: String,
        /// Line of the first one.
        first_line: usize,
    },
    /// A degree of freedom that changes the skeleton.
    #[error(
        "bone `{bone}`: expected rx, ry or rz, found `{found}`: bones that move or stretch are not \
         supported"
    )]
    NotRotation {
        /// The bone.
        bone: String,
        /// The degree of freedom.
        found: String,
    },
    /// The hierarchy does not hold the bone.
    #[error("bone `{bone}`: expected a place below `root` in the hierarchy, found none")]
    NotInHierarchy {
        /// The bone.
        bone: String,
    },
    /// A bone of a length that points nowhere.
    #[error("bone `{bone}`: expected a direction for its length of {length}, found 0 0 0")]
    NoDirection {
        /// The bone.
        bone: String,
        /// The length as in the file.
        length: String,
    },
    /// More than a motion of a figure can need.
    #[error("expected at most {limit} {items}, found more")]
    TooMany {
        /// The kind of items that are too many.
        items: &'static str,
        /// The limit.
        limit: usize,
    },
    /// The numbers do not count up, or leave out too many frames.
    #[error("expected a frame number from {least} to {most} after frame {last}, found {found}")]
    FrameNumber {
        /// The last frame's number.
        last: u64,
        /// The next one.
        least: u64,
        /// The furthest that can follow.
        most: u64,
        /// The number that follows.
        found: u64,
    },
    /// A bone has more or fewer angles than degrees of freedom.
    #[error("frame {frame}, bone `{bone}`: expected {expected}, found {found}")]
    Values {
        /// The frame's number.
        frame: u64,
        /// The bone.
        bone: String,
        /// How many values, and of what.
        expected: String,
        /// How many there are.
        found: usize,
    },
}
