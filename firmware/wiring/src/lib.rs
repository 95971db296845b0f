//! Wiring of a rig: how its servos are connected to a board, and how they are driven.
//!
//! A rig's compact form describes its joints and servos, but not their lines, makers or maximum currents. These are
//! its wiring. A host sends the wiring after the rig, as a single item ([`Wiring::append`]).
//!
//! - [`Wiring`]: the lines, the servos, and the rate of the loop, as bytes;
//! - [`Bus`]: the bus of a line; [`Lines`] and [`AllLines`]: the buses of all lines, with servos in the rig's order.
//!
//! # Files
//! - `wiring`: the whole wiring as bytes, and as settings of a controller.
//! - `line`, `lines`, `bus`: a line and a servo; all lines of a board; the bus of a line.
//! - `remote`: serialization of other crates' settings.
//! - `error`: errors of a wiring.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod bus;
mod error;
mod line;
mod lines;
mod remote;
mod wiring;

pub use bus::Bus;
pub use error::{VERSION, WiringError};
pub use line::{BusLine, Dynamixel, LineServo, Protocol, Pulses, Servo};
pub use lines::{AllLines, Lines};
pub use wiring::{LINES, Wiring};
