//! Tools that prepare bus servos before their first motion: find them, assign ids, set them up, calibrate them.
//!
//! ```text
//! command ──> functions of this crate ──> Client (packets, retries) ──> Exchange ──> a port, a simulated line, ..
//! ```
//!
//! - [`Exchange`] is a line: it sends bytes and returns the answer within a time. [`SerialLine`] is a line on a serial
//!   port.
//! - [`Client`] exchanges packets with servos over a line, in one protocol at one baud rate, and repeats lost
//!   questions.
//! - [`scan()`], [`find`], [`registers`], [`address`], [`identify`](mod@identify), [`watch`]: tools for any servo.
//! - [`rig_servo`], [`desired`], [`compare`]: the requirements of a rig file for its servos, and the comparison with
//!   them.
//! - [`calibrate`], [`rig_file`]: ranges found by hand, and how they are written to the rig file.
//!
//! ```no_run
//! use sinew_servo_tools::registers::{self, Number};
//! use sinew_servo_tools::{Client, Protocol, SerialLine, Settings};
//!
//! let line = SerialLine::open("/dev/ttyUSB0".as_ref())?;
//! let mut client = Client::new(line, Protocol::Dynamixel, 57_600, Settings::default())?;
//! let servo = client.open(1, None)?;
//! registers::write(&mut client, &servo, "return-delay-time", Number::Value(2.0))?; // us
//! for reading in registers::read(&mut client, &servo, &["present-position".to_owned()])? {
//!     println!("{}: {}", reading.name, reading.quantity); // Present Position: 180.00 deg
//! }
//! # Ok::<(), sinew_servo_tools::ServiceError>(())
//! ```
//!
//! Register values are in the servo's own counting: zero where the encoder counts zero. A rig's own positions count
//! from the middle of the encoder: [`rig_servo::own_rad`] converts.
//!
//! # Files
//! - `exchange`, `port`: a line of servos; a serial port as a line.
//! - `client`, `protocol`, `reply`, `ping_reply`: packets and retries; the servos' protocol; replies in received bytes.
//! - `servo`, `table`, `registers`, `quantity`, `store`: a servo that answered; its registers; reads and writes by
//!   name; numbers in units for people; verified writes.
//! - `scan`, `address`, `identify`, `watch`: search; ids and baud rates; a motion that shows which servo it is;
//!   measurements.
//! - `rig_servo`, `position_gain`, `desired`, `compare`: servos of a rig file; their P gains; the required registers;
//!   the differences.
//! - `guard`, `follow`, `left`: restores a servo that a tool changes; checks reported positions; finds servos that a
//!   killed program left.
//! - `calibrate`, `rig_file`: ranges found by hand; the rig file with these ranges.
//! - `lerobot`: converts `LeRobot`'s calibration to changes of a rig file, and a rig file to such a calibration.
//! - `error`: errors of all tools.

#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::missing_errors_doc)]
#![cfg_attr(
    test,
    allow(
        clippy::unwrap_used,
        clippy::expect_used,
        clippy::panic,
        reason = "a test may fail by panicking"
    )
)]

pub mod address;
pub mod calibrate;
mod client;
pub mod compare;
pub mod desired;
mod error;
mod exchange;
mod follow;
mod guard;
pub mod identify;
pub mod left;
pub mod lerobot;
mod ping_reply;
mod port;
pub mod position_gain;
mod protocol;
pub mod quantity;
pub mod registers;
mod reply;
pub mod rig_file;
pub mod rig_servo;
mod scan;
mod servo;
mod store;
mod table;
pub mod tap;
pub mod watch;

pub use client::{Client, Settings};
pub use error::{Registers, ServiceError};
pub use exchange::Exchange;
pub use port::{SerialLine, open_alone, usb_ports};
pub use protocol::Protocol;
pub use scan::{Found, ScanEvent, ScanSettings, anyone, find, scan};
pub use servo::Servo;
pub use table::Table;
