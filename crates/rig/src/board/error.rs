//! Why bytes are no rig, or a rig does not go on a board.

use core::fmt;

use sinew_core::TreeError;

use crate::drive::DriveError;
use crate::servo::ServoError;

/// Why bytes are no rig, or a rig does not go on a board.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum BoardRigError {
    /// The rig has more of something than the board holds.
    Capacity {
        /// Of what.
        what: &'static str,
        /// How many it has.
        found: usize,
        /// How many the board holds.
        holds: usize,
    },
    /// The bytes do not begin with `SNWR`.
    Magic {
        /// How they begin.
        found: [u8; 4],
    },
    /// The rig is of another version than 1.
    Version {
        /// Its version.
        found: u16,
    },
    /// There are fewer or more bytes than the rig takes.
    Length {
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// The bytes were damaged.
    Checksum {
        /// The CRC they carry.
        stored: u32,
        /// The CRC of their content.
        computed: u32,
    },
    /// There is no such kind of something.
    Kind {
        /// Of what: `"joint of body"`, `"drive"`, ...
        what: &'static str,
        /// Which one.
        index: usize,
        /// The number of the kind.
        found: u16,
        /// The largest number that there is.
        most: u16,
    },
    /// Something is counted wrongly.
    Count {
        /// What.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// Something names a part that there is not.
    Index {
        /// What names it: `"drive"`, `"limit"`.
        what: &'static str,
        /// Which one.
        index: usize,
        /// The part: `"dof"`, `"servo"`.
        part: &'static str,
        /// The index of the part.
        found: usize,
    },
    /// Two of a kind share what one alone may have.
    Shared {
        /// The kind of item: `"dof"`, `"servo"`, `"address of servo"`.
        what: &'static str,
        /// Index of the second one that has it.
        index: usize,
    },
    /// A number is NaN, or cannot be.
    Number {
        /// The kind of number: `"range of dof"`, ...
        what: &'static str,
        /// Which one.
        index: usize,
        /// The number.
        found: f32,
    },
    /// A drive does not fit its joints: their dofs are not whole, or it moves a ball joint as if it had axes.
    Joints {
        /// The drive.
        drive: usize,
    },
    /// The bodies cannot be.
    Tree(TreeError),
    /// A drive cannot be.
    Drive {
        /// Which one.
        index: usize,
        /// Why.
        error: DriveError,
    },
    /// A servo cannot be.
    Servo {
        /// Which one.
        index: usize,
        /// Why.
        error: ServoError,
    },
}

impl fmt::Display for BoardRigError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Capacity { what, found, holds } => {
                write!(f, "the rig has {found} {what}, the board holds {holds}")
            }
            Self::Magic { found } => {
                write!(f, "not a rig: it begins with {found:02x?} instead of `SNWR`")
            }
            Self::Version { found } => {
                write!(f, "the rig is of version {found}; this firmware reads version 1")
            }
            Self::Length { expected, found } => {
                write!(f, "the rig has {found} bytes where {expected} are needed")
            }
            Self::Checksum { stored, computed } => write!(
                f,
                "the rig is damaged: it carries CRC {stored:08x}, its content has {computed:08x}"
            ),
            Self::Kind { what, index, found, most } => {
                write!(f, "{what} {index} is of kind {found}; kinds are 0 to {most}")
            }
            Self::Count { what, expected, found } => {
                write!(f, "there are {found} {what}; there must be {expected}")
            }
            Self::Index { what, index, part, found } => {
                write!(f, "{what} {index} names {part} {found}, which there is not")
            }
            Self::Shared { what, index } => {
                write!(f, "{what} {index} is taken already; each may be used once")
            }
            Self::Number { what, index, found } => {
                write!(f, "{what} {index} is {found}, which cannot be")
            }
            Self::Joints { drive } => write!(
                f,
                "drive {drive} does not fit its joints: it must move all dofs of each, and a ball joint alone"
            ),
            Self::Tree(error) => write!(f, "the rig's bodies: {error}"),
            Self::Drive { index, error } => write!(f, "drive {index}: {error}"),
            Self::Servo { index, error } => write!(f, "servo {index}: {error}"),
        }
    }
}

impl core::error::Error for BoardRigError {}
