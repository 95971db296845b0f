//! The reason why bytes are not a valid rig, or a rig does not fit a board.

use core::fmt;

use sinew_core::TreeError;

use crate::drive::DriveError;
use crate::servo::ServoError;

/// The reason why bytes are not a valid rig, or a rig does not fit a board.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum BoardRigError {
    /// The rig has more of something than the board holds.
    Capacity {
        /// Kind of part, such as `"bodies"`.
        what: &'static str,
        /// Number of parts that the rig has.
        found: usize,
        /// Number of parts that the board has room for.
        holds: usize,
    },
    /// The bytes do not begin with `SNWR`.
    Magic {
        /// First four bytes that were found.
        found: [u8; 4],
    },
    /// The rig has a format version other than 1.
    Version {
        /// Version that was found.
        found: u16,
    },
    /// The number of bytes differs from the length of the rig, or is too small to write the rig.
    Length {
        /// Expected number of bytes.
        expected: usize,
        /// Number of bytes that were found.
        found: usize,
    },
    /// The bytes were damaged.
    Checksum {
        /// CRC that is stored with the rig.
        stored: u32,
        /// CRC computed from the content.
        computed: u32,
    },
    /// The number that encodes the kind of a part is unknown.
    Kind {
        /// Part whose kind it is: `"joint of body"`, `"drive"`, ...
        what: &'static str,
        /// Index of that part.
        index: usize,
        /// Number of the kind that was found.
        found: u16,
        /// Largest known number of a kind.
        most: u16,
    },
    /// The number of bodies, dofs, or a drive's dofs or servos does not fit the other parts.
    Count {
        /// Parts that are counted.
        what: &'static str,
        /// Expected count.
        expected: usize,
        /// Count that was found.
        found: usize,
    },
    /// A part refers to another part that does not exist.
    Index {
        /// Kind of the part that refers to the missing part: `"drive"`, `"limit"`.
        what: &'static str,
        /// Index of the part that refers to the missing part.
        index: usize,
        /// Kind of the missing part: `"dof"`, `"servo"`.
        part: &'static str,
        /// Index of the missing part.
        found: usize,
    },
    /// Two parts use a dof, servo or address that only one may use.
    Shared {
        /// Kind of the shared item: `"dof"`, `"servo"`, `"address of servo"`.
        what: &'static str,
        /// Index of that item, or of the limit or servo that uses it a second time.
        index: usize,
    },
    /// A number is NaN or out of its range.
    Number {
        /// Kind of number: `"range of dof"`, ...
        what: &'static str,
        /// Index of the part that the number belongs to.
        index: usize,
        /// Number that was found.
        found: f32,
    },
    /// A drive does not fit its joints: it moves only some dofs of a joint, or treats a ball joint as a joint with
    /// axes.
    Joints {
        /// Index of the drive.
        drive: usize,
    },
    /// The tree of bodies is invalid.
    Tree(TreeError),
    /// A drive is invalid.
    Drive {
        /// Index of the drive.
        index: usize,
        /// Reason why the drive is invalid.
        error: DriveError,
    },
    /// A servo is invalid.
    Servo {
        /// Index of the servo.
        index: usize,
        /// Reason why the servo is invalid.
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
                write!(f, "{what} {index} refers to {part} {found}, which does not exist")
            }
            Self::Shared { what, index } => {
                write!(f, "{what} {index} is taken already; each may be used once")
            }
            Self::Number { what, index, found } => {
                write!(f, "{what} {index} is {found}, which is invalid")
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
