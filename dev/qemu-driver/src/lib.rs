//! Plays shows of any rig on the node that boards run, as an image in QEMU.
//!
//! ```text
//! Node: rig, settings, show, commands, over the link ──> image ──> packets of each line ──> simulated servos
//!                                                          ║ the same?                         │ answers, to both
//!                              controller in this process ─╨─ Tally, Recorder  <───────────────┘
//! ```
//! The image's packets are sent to the servos. The controller in this process receives the same answers and commands in
//! the same ticks, and all outputs of both are compared: each packet, and in each tick state, commanded pose, efforts
//! and errors, bit for bit. Therefore tables and recordings of the controller in this process are valid for both.
//!
//! - `emulator`: the process of QEMU, as a pair of pipes;
//! - `node`: a node over these pipes, and its host link;
//! - `set_up`: power-on, and uploads of rig, settings and show;
//! - `controller`: the node as the peer of a [`SimulatedRig`](sinew_performance::play)'s controller.

#![forbid(unsafe_code)]
#![deny(missing_docs)]

mod controller;
mod emulator;
mod error;
mod node;
mod set_up;
#[cfg(test)]
mod tests;

pub use controller::QemuController;
pub use emulator::{Emulator, IMAGE};
pub use error::QemuError;
