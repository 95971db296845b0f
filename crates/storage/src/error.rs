//! Errors of tables, capacities and of what is stored.

use core::fmt::Debug;

use thiserror::Error;

/// Why something was not stored, or not read. `E` is the flash driver's error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum Error<E: Debug> {
    /// The driver refused.
    #[error("the flash refused: {0:?}")]
    Flash(E),
    /// The table does not fit the flash.
    #[error("the board's table: {0}")]
    Table(TableError),
    /// What was read back is not what was written, or a sector is not blank after its erase.
    #[error("flash at {at:#x} does not store the written data: is the sector worn out?")]
    ReadBack {
        /// Where.
        at: u32,
    },
    /// A place that should be blank, or hold the same, holds something else: what a power cut leaves.
    #[error("flash at {at:#x} holds data that a power cut left incomplete: begin the upload again")]
    Torn {
        /// Where.
        at: u32,
    },
    /// The log has no room for it.
    #[error("the log has {free} bytes free, {needed} are needed")]
    Full {
        /// Bytes that it takes.
        needed: u32,
        /// Bytes that are free.
        free: u32,
    },
    /// The log has to be put in order first: [`Store::tidy`](crate::Store::tidy), while the rig is limp.
    #[error("the log has to be tidied first, while the rig is limp")]
    Untidy,
    /// No slot is large enough.
    #[error("the show has {len} bytes, the largest slot holds {holds}")]
    TooLong {
        /// Bytes of the show.
        len: u32,
        /// Bytes that the largest slot holds.
        holds: u32,
    },
    /// Every slot that is large enough holds a show.
    #[error("all slots for {len} bytes hold shows: delete one first")]
    NoFreeSlot {
        /// Bytes of the show.
        len: u32,
    },
    /// There is no such slot.
    #[error("there is no slot {slot}: there are {slots} slots, numbered from 0")]
    Slot {
        /// Its number.
        slot: usize,
        /// How many slots there are.
        slots: usize,
    },
    /// A block is beyond the ones that are there.
    #[error("the block begins at {found}, but only {expected} bytes are there: go on from there")]
    Order {
        /// Bytes that are there.
        expected: u32,
        /// Where the block begins.
        found: u32,
    },
    /// A block begins or ends where flash cannot.
    #[error(
        "blocks begin and end at multiples of {granule} bytes; this one is {len} bytes at {offset}"
    )]
    Alignment {
        /// The flash's own unit.
        granule: u32,
        /// Where the block begins.
        offset: u32,
        /// Its length.
        len: usize,
    },
    /// A block goes beyond the end of the item.
    #[error("the block ends at {found}, the item has {len} bytes")]
    Beyond {
        /// Where the block ends.
        found: u32,
        /// Bytes of the item.
        len: u32,
    },
    /// The content has another hash than was announced. The upload is dropped.
    #[error("the content has another SHA-256 than was announced: it is discarded")]
    Hash,
    /// The place of this upload was given up since it began.
    #[error("the slot of this upload was given up: begin the upload again")]
    Stale,
    /// The rig is none, or this board does not hold it. The upload is dropped.
    #[error("{0}")]
    Capacity(CapacityError),
}

impl<E: Debug> From<CapacityError> for Error<E> {
    fn from(error: CapacityError) -> Self {
        Self::Capacity(error)
    }
}

/// Why a board does not take a rig.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum CapacityError {
    /// It is too large.
    #[error("the rig has {found} {what}, the board holds {holds}")]
    TooLarge {
        /// Of what it has too many.
        what: &'static str,
        /// How many it has.
        found: u16,
        /// How many the board holds.
        holds: u16,
    },
    /// The bytes do not begin as a rig of version 1.
    #[error("not a rig of version 1: it begins with {found:02x?} in place of `SNWR`, 1")]
    NotARig {
        /// How they begin.
        found: [u8; 6],
    },
}

/// Why a table cannot be.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum TableError {
    /// The flash writes units that are no power of two up to 32 bytes.
    #[error("the flash writes {found} bytes at once; 1, 2, 4, 8, 16, 32 are possible")]
    Granule {
        /// Bytes it writes at once.
        found: usize,
    },
    /// Areas begin at multiples of 64 bytes, sectors have multiples of 64, and those of the log hold all faults.
    #[error(
        "the area at {start:#x} has sectors of {sector_len} bytes: sectors must be multiples of 64 bytes, at least \
         {least}"
    )]
    Sector {
        /// Where the area begins.
        start: u32,
        /// The length of its sectors.
        sector_len: u32,
        /// The least length.
        least: u32,
    },
    /// The log has one sector, or an area none.
    #[error("the area at {start:#x} has {found} sectors, it needs {least}")]
    Sectors {
        /// Where the area begins.
        start: u32,
        /// How many sectors it has.
        found: u32,
        /// How many it needs.
        least: u32,
    },
    /// An area ends behind the flash.
    #[error("the area at {start:#x} ends at {end:#x}, the flash at {capacity:#x}")]
    Beyond {
        /// Where the area begins.
        start: u32,
        /// Where it ends.
        end: u64,
        /// Bytes of flash.
        capacity: u64,
    },
    /// Two areas share sectors.
    #[error("the areas at {first:#x} and {second:#x} overlap")]
    Overlap {
        /// Where one begins.
        first: u32,
        /// Where the other begins.
        second: u32,
    },
}
