//! Errors in shows.

use core::fmt;

use crate::joint::Joint;

/// A reason for which a show cannot be performed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ShowError {
    /// The file does not start with `SNWS`.
    Magic {
        /// First bytes of the file.
        found: [u8; 4],
    },
    /// The show's version is not 2.
    Version {
        /// Version of the show.
        found: u16,
    },
    /// The show is shorter or longer than its header states.
    Length {
        /// Expected length, in bytes.
        expected: usize,
        /// Actual length, in bytes.
        found: usize,
    },
    /// The head is damaged.
    Checksum {
        /// Stored CRC.
        stored: u32,
        /// CRC of the content.
        computed: u32,
    },
    /// A block is damaged.
    Block {
        /// Index of the block.
        block: u32,
        /// Stored CRC.
        stored: u32,
        /// CRC of the content.
        computed: u32,
    },
    /// The curve of a channel does not continue from block to block, although no CRC is wrong.
    Broken {
        /// Index of the block.
        block: u32,
        /// Index of the channel.
        channel: usize,
    },
    /// A field of the head is invalid.
    Field {
        /// Name of the field.
        what: &'static str,
        /// Index of the item that the field belongs to, or 0.
        index: usize,
        /// Value of the field, whole or rounded.
        found: u32,
    },
    /// The show has more channels than the capacity.
    Capacity {
        /// Number of channels of the show.
        found: usize,
        /// Maximum number of channels.
        holds: usize,
    },
    /// The show is for another rig.
    Rig {
        /// The CRC of the rig that the show was made for.
        show: u32,
        /// CRC of the present rig.
        here: u32,
    },
    /// The number of joints is not the rig's.
    Joints {
        /// Number of joints of the show.
        show: usize,
        /// Number of joints of the rig.
        here: usize,
    },
    /// A joint is of another kind than the rig's joint.
    Joint {
        /// Index of the joint.
        index: usize,
        /// Kind of the joint in the show.
        show: Joint,
        /// Kind of the joint in the rig.
        here: Joint,
    },
    /// The first pose is beyond a range of the rig, so the rig would never reach this pose.
    Range {
        /// Index of the dof.
        dof: usize,
        /// Position of the dof in the first pose, rad or m.
        found: f32,
        /// Lower end of the rig's range, rad or m.
        least: f32,
        /// Upper end of the rig's range, rad or m.
        most: f32,
    },
}

impl fmt::Display for ShowError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Magic { found } => {
                write!(f, "not a show: it begins with {found:02x?} instead of `SNWS`")
            }
            Self::Version { found: 1 } => f.write_str(
                "the show is of version 1, which is no longer read: bake it again from its clip, with `sinew bake CLIP \
                 --rig RIG`",
            ),
            Self::Version { found } => {
                write!(f, "the show is of version {found}; this program performs version 2")
            }
            Self::Length { expected, found } => {
                write!(f, "the show has {found} bytes where its head asks for {expected}")
            }
            Self::Checksum { stored, computed } => write!(
                f,
                "the head of the show is damaged: it carries CRC {stored:08x}, its content has {computed:08x}"
            ),
            Self::Block { block, stored, computed } => write!(
                f,
                "block {block} of the show is damaged: it carries CRC {stored:08x}, its content has {computed:08x}"
            ),
            Self::Broken { block, channel } => write!(
                f,
                "channel {channel} does not go on into block {block}: the program that wrote the show has a fault"
            ),
            Self::Field { what, index, found } => {
                write!(f, "{what} {index} of the show is {found}, which is invalid")
            }
            Self::Capacity { found, holds } => {
                write!(f, "the show has {found} joint coordinates, the board holds {holds}")
            }
            Self::Rig { show, here } => write!(
                f,
                "the show was made for rig {show:08x}, here is rig {here:08x}: bake it again for this rig"
            ),
            Self::Joints { show, here } => {
                write!(f, "the show has {show} joints, the rig has {here}")
            }
            Self::Joint { index, show, here } => {
                write!(f, "joint {index} is {show} in the show, {here} in the rig")
            }
            Self::Range { dof, found, least, most } => write!(
                f,
                "the show begins with dof {dof} at {found:.3}, beyond its range of {least:.3} to {most:.3} (rad or m): \
                 bake it again for this rig"
            ),
        }
    }
}

impl core::error::Error for ShowError {}
