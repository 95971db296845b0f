//! Persistent storage of a board: settings, rig and faults in a log, shows in raw slots. See `docs/storage.md`.
//!
//! - [`BoardTable`] is a board's declaration: its free areas of flash, and its capacity for a rig.
//! - [`Store`] keeps items in any NOR flash ([`embedded_storage::nor_flash::NorFlash`]). Every item has a
//!   [`Descriptor`]: schema version, SHA-256, the rig it belongs to, and its approver.
//! - [`Upload`] writes an item block by block. After a power cut it continues where it stopped.
//! - [`Faults`]: the first fault since they were cleared, and the last ones.
//! - [`Disarmed`] is a required argument of every function that erases. There is only one value, and only the
//!   supervisor of a limp rig can lend it.
//!
//! An item is intact or absent: its seal is written last, and no item is written over the item it replaces. `no_std`:
//! no allocation, no `unsafe`, no panic, no f64.
//!
//! # The flash is blocking
//! Erasing on-chip flash stops the core anyway, and a future dropped in the middle of a write would act like a power
//! cut. Storage is therefore called from the background task, and returns when it is done.
//!
//! # Files
//! From the flash up:
//! - `flash`: bytes in any NOR flash: aligned, read back, never written twice in one place.
//! - `record`: head, payload, and a seal that is written last.
//! - `log`, `compact`, `damage`, `fault`: records in a sector; their copy in the next sector; lost items; faults.
//! - `area`, `board`, `descriptor`, `disarmed`, `error`: sectors of flash; a board's declaration; an item's
//!   description; the permission to erase; errors.
//! - `place`, `upload`, `stored`: room for an item; an item that arrives in blocks; an intact item.
//! - `store`: the interface to all of these.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::cast_possible_truncation,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod area;
mod board;
mod compact;
mod damage;
mod descriptor;
mod disarmed;
mod error;
mod fault;
mod flash;
mod log;
mod place;
mod record;
mod store;
mod stored;
mod upload;

pub use area::Area;
pub use board::{BoardTable, Capacity};
pub use descriptor::{Approver, ApproverError, Descriptor, Hash, Kind, SchemaError};
pub use disarmed::Disarmed;
pub use error::{CapacityError, Error, TableError};
pub use fault::{FAULTS_KEPT, Fault, Faults};
pub use store::{Condition, Store};
pub use stored::Stored;
pub use upload::Upload;
