//! Errors of board tables, capacities and stored items.

use core::fmt::Debug;

use thiserror::Error;

/// An error of storing or reading. `E` is the flash driver's error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Error<E: Debug> {
    /// The flash driver reported an error.
    #[error("the flash refused: {0:?}")]
    Flash(E),
    /// The board's table does not fit the flash.
    #[error("the board's table: {0}")]
    Table(TableError),
    /// The data read back differ from the written data, or a sector is not blank after its erase.
    #[error("flash at {at:#x} does not store the written data: is the sector worn out?")]
    ReadBack {
        /// Address of the data.
        at: u32,
    },
    /// The flash is neither blank nor already holds the new data, because of a power cut.
    #[error("flash at {at:#x} holds data that a power cut left incomplete: begin the upload again")]
    Torn {
        /// Address of the data.
        at: u32,
    },
    /// The log has no room for the record.
    #[error("the log has {free} bytes free, {needed} are needed")]
    Full {
        /// Needed length, in bytes.
        needed: u32,
        /// Free length, in bytes.
        free: u32,
    },
    /// The log must be tidied first: [`Store::tidy`](crate::Store::tidy), while the rig is limp.
    #[error("the log has to be tidied first, while the rig is limp")]
    Untidy,
    /// The show is longer than every slot.
    #[error("the show has {len} bytes, the largest slot holds {holds}")]
    TooLong {
        /// Length of the show, in bytes.
        len: u32,
        /// Capacity of the largest slot, in bytes.
        holds: u32,
    },
    /// Every slot that is large enough holds a show.
    #[error("all slots for {len} bytes hold shows: delete one first")]
    NoFreeSlot {
        /// Length of the show, in bytes.
        len: u32,
    },
    /// There is no slot with this number.
    #[error("there is no slot {slot}: there are {slots} slots, numbered from 0")]
    Slot {
        /// Number of the slot.
        slot: usize,
        /// Number of slots.
        slots: usize,
    },
    /// A block starts beyond the received bytes.
    #[error("the block begins at {found}, but only {expected} bytes are there: go on from there")]
    Order {
        /// Number of received bytes.
        expected: u32,
        /// Offset of the block.
        found: u32,
    },
    /// A block starts or ends at an offset that the flash does not support.
    #[error(
        "blocks begin and end at multiples of {granule} bytes; this one is {len} bytes at {offset}"
    )]
    Alignment {
        /// Write granule of the flash, in bytes.
        granule: u32,
        /// Offset of the block.
        offset: u32,
        /// Length of the block, in bytes.
        len: usize,
    },
    /// A block ends beyond the end of the item.
    #[error("the block ends at {found}, the item has {len} bytes")]
    Beyond {
        /// End of the block.
        found: u32,
        /// Length of the item, in bytes.
        len: u32,
    },
    /// The SHA-256 of the content is not the announced one. The upload is dropped.
    #[error("the content has another SHA-256 than was announced: it is discarded")]
    Hash,
    /// The place of this upload was given up after its start.
    #[error("the slot of this upload was given up: begin the upload again")]
    Stale,
    /// The content is not a rig, or the rig exceeds the board's capacity. The upload is dropped.
    #[error("{0}")]
    Capacity(CapacityError),
}

impl<E: Debug> From<CapacityError> for Error<E> {
    fn from(error: CapacityError) -> Self {
        Self::Capacity(error)
    }
}

/// A reason for which a board refuses a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CapacityError {
    /// The rig is too large.
    #[error("the rig has {found} {what}, the board holds {holds}")]
    TooLarge {
        /// Name of the count that is too large.
        what: &'static str,
        /// Count in the rig.
        found: u16,
        /// Maximum count on the board.
        holds: u16,
    },
    /// The bytes do not start like a rig of version 1.
    #[error("not a rig of version 1: it begins with {found:02x?} in place of `SNWR`, 1")]
    NotARig {
        /// First bytes of the content.
        found: [u8; 6],
    },
}

/// An error in a board's table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The flash's write size is not a power of two up to 32 bytes.
    #[error("the flash writes {found} bytes at once; 1, 2, 4, 8, 16, 32 are possible")]
    Granule {
        /// Write size of the flash, in bytes.
        found: usize,
    },
    /// An area does not start at a multiple of 64 bytes, a sector's length is not a multiple of 64, or a sector of
    /// the log is too short for all faults.
    #[error(
        "the area at {start:#x} has sectors of {sector_len} bytes: sectors must be multiples of 64 bytes, at least \
         {least}"
    )]
    Sector {
        /// Start address of the area.
        start: u32,
        /// Length of the area's sectors, in bytes.
        sector_len: u32,
        /// Minimum length, in bytes.
        least: u32,
    },
    /// The log has fewer than two sectors, or an area has none.
    #[error("the area at {start:#x} has {found} sectors, it needs {least}")]
    Sectors {
        /// Start address of the area.
        start: u32,
        /// Number of the area's sectors.
        found: u32,
        /// Minimum number of sectors.
        least: u32,
    },
    /// An area ends beyond the end of the flash.
    #[error("the area at {start:#x} ends at {end:#x}, the flash at {capacity:#x}")]
    Beyond {
        /// Start address of the area.
        start: u32,
        /// End address of the area.
        end: u64,
        /// Length of the flash, in bytes.
        capacity: u64,
    },
    /// Two areas overlap.
    #[error("the areas at {first:#x} and {second:#x} overlap")]
    Overlap {
        /// Start address of one area.
        first: u32,
        /// Start address of the other area.
        second: u32,
    },
}
