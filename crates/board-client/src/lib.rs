//! The host's side of a controller.
//!
//! ```text
//! command ──> Board (session, numbers, heartbeats) ──> Line ──> a serial port, an emulator, a simulated board
//!    └─ BoardServos (a line of servos for `sinew-servo-tools`) ─┘
//! ```
//!
//! - [`Line`] is bytes out and bytes in, with a clock; [`SerialBoard`] is one on a serial port.
//! - [`Board`] is a session on it: [`Board::ask`] sends a command until it is answered, [`Board::step`] takes what
//!   comes and says every 50 ms that the host is there. A host that hears nothing for 1 s says `Stop`, and is silent.
//! - [`TelemetryLog`] is what telemetry has told, put together again.
//! - [`Board::upload`] brings rigs, settings and shows, block by block, and goes on where it was interrupted.
//! - [`BoardServos`]: the controller passes packets on while its rig is limp.
//! - [`port`]: which ports have a controller, and what a port is that has none.
//!
//! ```no_run
//! use sinew_board_client::port;
//! use sinew_link::message::Command;
//!
//! let mut board = port::open("/dev/ttyACM0".as_ref())?;
//! println!("firmware {}", board.about().firmware);
//! board.ask(Command::Arm)?;
//! # Ok::<(), sinew_board_client::ClientError>(())
//! ```
//!
//! # Files
//! - `board`, `upload`: a session; items that a board stores.
//! - `line`, `port`: bytes to a board and back; serial ports that have a board.
//! - `servos`: a board as a line of servos.
//! - `telemetry_log`: telemetry and faults that arrived.
//! - `error`: errors of a session.

#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::missing_errors_doc)]

mod board;
mod error;
mod line;
pub mod port;
mod servos;
mod telemetry_log;
mod upload;

pub use board::{Board, SILENCE, nonce};
pub use error::ClientError;
pub use line::{Line, SerialBoard};
pub use servos::BoardServos;
pub use telemetry_log::{TelemetryLog, TimedPose};
pub use upload::item;
