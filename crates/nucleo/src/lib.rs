//! The emulated NUCLEO-F446RE, controlled by a host.
//!
//! A separate tool, `dev/nucleo/emulator/`, emulates the chip in its own process. This crate controls it: [`Machine`]
//! runs it in lockstep, and [`BoardOnServos`] connects simulated servos to its bus, with the time of each byte.
//!
//! # Files
//! - `machine`: the emulator's process, with a text protocol of lines.
//! - `link`: an emulated board as a line of `sinew-board-client`.
//! - `on_servos`: simulated servos on the board's bus, in lockstep.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod link;
mod machine;
mod on_servos;

pub use link::EmulatedBoard;
pub use machine::{Machine, MachineError, MachineEvent, Port, Stopped};
pub use on_servos::{BoardOnServos, Burst, RunLog};
