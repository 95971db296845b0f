//! Persistent storage of a board: settings, rig and faults in a log, shows in raw slots. See `docs/storage.md`.
//!
//! - [`BoardTable`] is what a board declares: where its flash is free, and how large a rig it holds.
//! - [`Store`] keeps items in any NOR flash ([`embedded_storage::nor_flash::NorFlash`]). Every item has a
//!   [`Descriptor`]: schema version, SHA-256, the rig it belongs to, and who approved it.
//! - [`Upload`] brings an item by blocks. It goes on where a cut left it.
//! - [`Faults`]: the first fault since they were cleared, and the last ones.
//! - [`Disarmed`] is asked for by all that erases. There is one of it, and only a limp rig's controller can lend it.
//!
//! An item is whole or not there: its seal is written last, and no item is written over the one it replaces.
//! `no_std`: no allocation, no `unsafe`, no panic, no f64.
//!
//! # The flash is blocking
//! Erasing on-chip flash stops the core anyway, and a future that is dropped in the middle of a write is a power cut.
//! So storage is called from below the control loop, and returns when it is done.
//!
//! # Files
//! From the flash up:
//! - `flash`: bytes in any NOR flash: aligned, read back, never written twice in one place.
//! - `record`: head, payload, and a seal that is written last.
//! - `log`, `compact`, `damage`, `fault`: records in a sector; their copy in the next one; what was lost; faults.
//! - `area`, `board`, `descriptor`, `disarmed`, `error`: sectors of flash; a board's declaration; an item's
//!   description; the permission to erase.
//! - `place`, `upload`, `stored`: room for an item; an item that arrives in blocks; an item that is whole.
//! - `store`: all of these behind one type.

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
