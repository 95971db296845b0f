//! The emulated NUCLEO-F446RE as a host sees it.
//!
//! The chip is emulated by a tool of its own, `dev/nucleo/emulator/`, in a process of its own. Here is its other end:
//! [`Machine`] runs it in lock-step, and [`BoardOnServos`] has simulated servos at its bus, each byte at its time.
//!
//! # Files
//! - `machine`: the emulator's process, one line of text each way.
//! - `link`: an emulated board as a line of `sinew-board-client`.
//! - `on_servos`: simulated servos at the board's bus, in lock-step.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod link;
mod machine;
mod on_servos;

pub use link::EmulatedBoard;
pub use machine::{Machine, MachineError, MachineEvent, Port, Stopped};
pub use on_servos::{BoardOnServos, Burst, RunLog};
