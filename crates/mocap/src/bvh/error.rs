//! Why a BVH file was refused.

use std::path::PathBuf;

use crate::text::{Position, counted};

/// A BVH file that cannot be read.
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
    /// The text is not a BVH motion.
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

/// What is wrong at a place of a BVH file.
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
    /// A second `ROOT`.
    #[error("expected `MOTION`, found a second `ROOT`: a clip holds one skeleton")]
    SecondRoot,
    /// A name that is already taken.
    #[error("expected a new joint name, found `{name}`, which line {first_line} names already")]
    DuplicateJoint {
        /// The name.
        name: String,
        /// Line of the first joint of this name.
        first_line: usize,
    },
    /// A channel that the joint has already.
    #[error("expected another channel, found a second `{channel}` in joint `{joint}`")]
    DuplicateChannel {
        /// The channel as written.
        channel: String,
        /// The joint.
        joint: String,
    },
    /// More than a motion of a figure can need.
    #[error("expected at most {limit} {items}, found more")]
    TooMany {
        /// The kind of items that are too many.
        items: &'static str,
        /// The limit.
        limit: usize,
    },
    /// No joint has a channel.
    #[error("expected at least one channel in the hierarchy, found none")]
    NoChannels,
    /// The values end too early.
    #[error(
        "the file ends after {} of {frames}: expected {} in each, found {rest} of the next{}",
        counted(*complete, "frame"), counted(*channels, "value"), hint(*odd_line)
    )]
    MissingValues {
        /// Frames as the header says.
        frames: usize,
        /// Values in a frame.
        channels: usize,
        /// Frames that are complete.
        complete: usize,
        /// Values of the frame that is not.
        rest: usize,
        /// The first line that does not hold exactly one frame: its number and its values.
        odd_line: Option<(usize, usize)>,
    },
    /// There are more values than the header says.
    #[error(
        "expected the end of the file after {} of {}, found {extra} more{}",
        counted(*frames, "frame"), counted(*channels, "value"), hint(*odd_line)
    )]
    ExtraValues {
        /// Frames as the header says.
        frames: usize,
        /// Values in a frame.
        channels: usize,
        /// Words after the last frame.
        extra: usize,
        /// The first line that does not hold exactly one frame: its number and its values.
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
