//! Why something was not stored, or not read.

use core::fmt::Debug;

use thiserror::Error;

use crate::board::{CapacityError, TableError};

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
    #[error("flash at {at:#x} does not keep what is written: is the sector worn out?")]
    ReadBack {
        /// Where.
        at: u32,
    },
    /// A place that should be blank, or hold the same, holds something else: what a power cut leaves.
    #[error("flash at {at:#x} holds what a cut left: begin the upload again")]
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
    #[error("there is no slot {slot}: slots are 0 to {slots}, less one")]
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
    #[error("the content has another SHA-256 than was announced: it is dropped")]
    Hash,
    /// The place of this upload was given up since it began.
    #[error("the place of this upload is gone: begin it again")]
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
