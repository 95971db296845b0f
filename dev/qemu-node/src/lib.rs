//! A whole node in an emulator: what an image for QEMU and its host share.
//!
//! ```text
//! host: line, simulated servos, clock ──  ToNode  ──> image: link, storage, loop; its flash is RAM
//!                                     <── ToHost  ──
//! ```
//! The node is that of every board, and what it reaches of hardware is at the host's. They go in lock-step: one of them
//! runs while the other waits, and time is what the host says. So a run is the same each time, and the bytes on its bus
//! and its line can be compared with those of a node in process.
//!
//! - [`built_in`]: what a board of a rig has built in: how its servos are driven, and its lines;
//! - [`arm`]: the same of the rig that tests move;
//! - [`limits`]: its sizes;
//! - [`message`]: what the two say to each other;
//! - [`node`]: the node over that, from one power-on to the next.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod arm;
pub mod built_in;
mod hardware;
pub mod limits;
pub mod message;
pub mod node;
