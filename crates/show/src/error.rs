//! Why a show cannot be performed.

use core::fmt;

use crate::joint::Joint;

/// Why a show cannot be performed.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum ShowError {
    /// It does not begin with `SNWS`.
    Magic {
        /// How it begins.
        found: [u8; 4],
    },
    /// It is of another version than 2.
    Version {
        /// Its version.
        found: u16,
    },
    /// It is shorter or longer than its header says.
    Length {
        /// Bytes there should be.
        expected: usize,
        /// Bytes there are.
        found: usize,
    },
    /// Its head was damaged.
    Checksum {
        /// The CRC it carries.
        stored: u32,
        /// The CRC of its content.
        computed: u32,
    },
    /// A block was damaged.
    Block {
        /// Which one.
        block: u32,
        /// The CRC it carries.
        stored: u32,
        /// The CRC of its content.
        computed: u32,
    },
    /// The curve of a channel does not go on from block to block, though no CRC is wrong.
    Broken {
        /// The block.
        block: u32,
        /// The channel.
        channel: usize,
    },
    /// A field of its head is none that can be.
    Field {
        /// The kind of value.
        what: &'static str,
        /// Of which item, if there are several.
        index: usize,
        /// The number in it, whole or rounded.
        found: u32,
    },
    /// It has more channels than there is room for.
    Capacity {
        /// How many it has.
        found: usize,
        /// How many there is room for.
        holds: usize,
    },
    /// It is of another rig.
    Rig {
        /// The CRC of the rig that the show was made for.
        show: u32,
        /// The CRC of the rig that is here.
        here: u32,
    },
    /// It has another number of joints than the rig.
    Joints {
        /// How many the show has.
        show: usize,
        /// How many the rig has.
        here: usize,
    },
    /// A joint is of another kind than the rig's.
    Joint {
        /// Which one.
        index: usize,
        /// Of what kind it is in the show.
        show: Joint,
        /// Of what kind the rig's is.
        here: Joint,
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
        }
    }
}

impl core::error::Error for ShowError {}
