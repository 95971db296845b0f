//! The host's side of a session with a controller.
//!
//! ```text
//! command ──> Board (session, numbers, heartbeats) ──> Line ──> a serial port, an emulator, a simulated board
//!    └─ BoardServos (a line of servos for `sinew-servo-tools`) ─┘
//! ```
//!
//! - [`Line`] sends and receives bytes, and has a clock; [`SerialBoard`] is a line on a serial port.
//! - [`Board`] is a session on a line. [`Board::ask`] sends a command until it is answered. [`Board::step`] receives
//!   messages and sends a heartbeat every 50 ms. A host that receives nothing for 1 s sends `Stop`, and then nothing
//!   more.
//! - [`TelemetryLog`] assembles telemetry from its frames.
//! - [`Board::upload`] uploads rigs, settings and shows, block by block, and continues after an interruption.
//! - [`BoardServos`]: the controller passes packets on while its rig is limp.
//! - [`Journey`]: a motion of all joints to a pose; [`commanded_pose`]: the pose that the board commands.
//! - [`console`]: asks a console that owns a board.
//! - [`port`]: finds ports with a controller, and identifies ports without one.
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
//! - `line`, `port`: bytes to and from a board; serial ports with a board.
//! - `journey`, `commanded_pose`: motions to a pose.
//! - `console/`: the socket of a console, for other commands.
//! - `servos`: a board as a line of servos.
//! - `telemetry_log`: received telemetry and faults.
//! - `error`: errors of a session.

#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::missing_errors_doc)]

mod board;
mod commanded_pose;
#[cfg(unix)]
pub mod console;
mod error;
mod journey;
mod line;
pub mod port;
mod servos;
mod telemetry_log;
mod upload;

pub use board::{Board, SILENCE, nonce};
pub use commanded_pose::commanded_pose;
pub use error::ClientError;
pub use journey::Journey;
pub use line::{Line, SerialBoard};
pub use servos::BoardServos;
pub use telemetry_log::{TelemetryLog, TimedPose};
pub use upload::item;
