//! The reason why a BVH file was refused.

use std::path::PathBuf;

use crate::text::{Position, counted};

/// The reason why a BVH file cannot be read.
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
    /// The text is not a valid BVH motion.
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

/// The error at a position of a BVH file.
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
    /// The file has a second `ROOT`.
    #[error("expected `MOTION`, found a second `ROOT`: a clip holds one skeleton")]
    SecondRoot,
    /// A joint name is used twice.
    #[error("expected a new joint name, found `{name}`, which line {first_line} names already")]
    DuplicateJoint {
        /// Name that is used twice.
        name: String,
        /// Line of the first joint with this name.
        first_line: usize,
    },
    /// A joint has the same channel twice.
    #[error("expected another channel, found a second `{channel}` in joint `{joint}`")]
    DuplicateChannel {
        /// Channel as written in the file.
        channel: String,
        /// Name of the joint.
        joint: String,
    },
    /// There are more items than a figure's motion can need.
    #[error("expected at most {limit} {items}, found more")]
    TooMany {
        /// Kind of items.
        items: &'static str,
        /// Maximum number of items.
        limit: usize,
    },
    /// No joint has a channel.
    #[error("expected at least one channel in the hierarchy, found none")]
    NoChannels,
    /// There are fewer values than the header announces.
    #[error(
        "the file ends after {} of {frames}: expected {} in each, found {rest} of the next{}",
        counted(*complete, "frame"), counted(*channels, "value"), hint(*odd_line)
    )]
    MissingValues {
        /// Number of frames according to the header.
        frames: usize,
        /// Number of values in a frame.
        channels: usize,
        /// Number of complete frames.
        complete: usize,
        /// Number of values of the incomplete frame.
        rest: usize,
        /// First line that does not contain exactly one frame: its number, and its number of values. `None` if there is
        /// none.
        odd_line: Option<(usize, usize)>,
    },
    /// There are more values than the header announces.
    #[error(
        "expected the end of the file after {} of {}, found {extra} more{}",
        counted(*frames, "frame"), counted(*channels, "value"), hint(*odd_line)
    )]
    ExtraValues {
        /// Number of frames according to the header.
        frames: usize,
        /// Number of values in a frame.
        channels: usize,
        /// Number of words after the last frame.
        extra: usize,
        /// First line that does not contain exactly one frame: its number, and its number of values. `None` if there is
        /// none.
        odd_line: Option<(usize, usize)>,
    },
}

fn hint(odd_line: Option<(usize, usize)>) -> String {
    odd_line.map_or_else(String::new, |(line, values)| {
        format!(
            "; line {line} is the first that is not one frame: it has {}",
            counted(values, "value")
        )
    })
}
