//! Feetech servos: STS and SMS, low byte first, and SCS, high byte first.
//!
//! `FF FF | ID | LEN | INST or status | params | SUM`, `LEN` = params + 2, `SUM` = NOT of the low byte of the sum from
//! id to the last param. There is no stuffing and no CRC: on average, one of 256 randomly damaged packets is accepted.
//! A reply therefore counts only with the right id and length, and a controller should believe only plausible values:
//! see [`Parser`] and [`Plausible`](crate::Plausible).
//!
//! An instruction and a reply look alike. If an adapter echoes the bytes that it sends, skip as many bytes as were
//! sent.
//!
//! Source: Feetech's protocol manual and memory tables, as in vassar-robotics/feetech-servo-sdk, `docs/reference`.

mod bus;
mod device;
mod frame;
mod instruction;
mod parser;
mod status;
pub mod table;

pub use bus::{Bus, Mode, ServoSetup, Settings, traffic};
pub use device::{Device, Event};
pub use frame::{BROADCAST, MAX_ID, Packet};
pub use instruction::{
    Instruction, SyncWriter, factory_reset, open_eeprom, set_middle, sync_blocks,
};
pub use parser::Parser;
pub use status::{Status, status_bit};
pub use table::{Family, Model, Table};
