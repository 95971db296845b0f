//! A whole node in an emulator: the parts that an image for QEMU and its host share.
//!
//! ```text
//! host: line, simulated servos, clock ──  ToNode  ──> image: link, storage, loop; its flash is RAM
//!                                     <── ToHost  ──
//! ```
//! The node is that of every board, and the host replaces its hardware. They run in lockstep: one of them runs while
//! the other waits, and the host sets the time. Therefore every run is the same, and the bytes on the bus and the
//! host link can be compared with those of a node in another program.
//!
//! - [`built_in`]: built-in parts of a rig's board: drives of its servos, and its lines;
//! - [`arm`]: the built-in parts for the rig of the tests;
//! - [`limits`]: sizes of the node;
//! - [`message`]: messages between host and node;
//! - [`node`]: the node that uses these messages, from one power-on to the next.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod arm;
pub mod built_in;
mod hardware;
pub mod limits;
pub mod message;
pub mod node;
