//! The emulated NUCLEO-F446RE as a host sees it.
//!
//! The chip is emulated by a tool of its own, `dev/nucleo/emulator/`, in a process of its own. Here is its other end:
//! [`Machine`] runs it in lock-step, and [`BoardOnServos`] has simulated servos at its bus, each byte at its time.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod link;
mod machine;
mod on_servos;

pub use link::EmulatedBoard;
pub use machine::{Machine, MachineError, MachineEvent, Port, Stopped};
pub use on_servos::{BoardOnServos, Burst, RunLog};
