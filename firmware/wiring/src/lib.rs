//! How a rig's servos hang on a board, and how they are driven.
//!
//! A rig's compact form says what its servos do: not on which line they are, who made them, or what current they bear.
//! That is its wiring, and a host sends it behind the rig, as one item ([`Wiring::append`]).
//!
//! - [`Wiring`]: the lines, the servos, and the rate of the loop, as bytes;
//! - [`Bus`]: the bus of one line; [`Lines`] and [`AllLines`]: those of all lines, servos in the rig's order.
//!
//! # Files
//! - `wiring`: the whole wiring as bytes, and as settings of a controller.
//! - `line`, `lines`, `bus`: one line and one servo; all lines of a board; the bus of one line.
//! - `remote`: numbers of other crates as messages carry them.
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
