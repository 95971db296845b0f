//! The host's side of a session with a controller.
//!
//! ```text
//! command ──> Board (session, numbers, heartbeats) ──> Line ──> a serial port, an emulator, a simulated board
//!    └─ BoardServos (a line of servos for `sinew-servo-tools`) ─┘
//! ```
//!
//! - [`Line`] sends and receives bytes, and has a clock; [`SerialBoard`] is a line on a serial port.
//! - [`Board`] is a session on a line. [`Board::ask`] sends a command until it is answered. [`Board::step`] receives
//!   messages and sends a heartbeat every 50 ms. A host with telemetry that receives nothing for 1 s (6 s while torque
//!   is off, longer at a low telemetry rate) sends `Stop`, and then nothing more.
//! - [`TelemetryLog`] assembles telemetry from its frames.
//! - [`Board::upload`] uploads rigs, settings and shows, block by block, and continues after an interruption.
//! - [`BoardServos`]: packets for servos, which the controller passes on while torque is off.
//! - [`Journey`]: a motion of all joints to a pose. [`IdleLife`]: a loop of poses. [`pose`]: conversions of poses, and
//!   the pose that the board commands.
//! - [`console`]: requests to a hub that uses a board.
//! - [`port`]: finds the port of a controller, and recognizes a port that has servos instead.
//!
//! ```no_run
//! use sinew_board_client::port;
//! use sinew_link::message::Command;
//!
//! let mut board = port::open("/dev/ttyACM0".as_ref(), &|| println!("the rig is lowered first"))?;
//! println!("firmware {}", board.about().firmware);
//! board.ask(Command::Arm)?;
//! # Ok::<(), sinew_board_client::ClientError>(())
//! ```
//!
//! # Files
//! - `board`: a session. `upload`: items that a board stores.
//! - `line`: bytes to and from a board. `port`: serial ports with a board.
//! - `journey`: motions to a pose. `idle_life`: a loop that a host plays. `pose`: poses as coordinates and as positions
//!   of dofs.
//! - `console/`: the socket through which other commands reach a hub.
//! - `servos`: a board as a line of servos.
//! - `telemetry_log`: received telemetry and faults.
//! - `error`: errors of a session.

#![forbid(unsafe_code)]
#![deny(missing_docs)]
#![warn(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::missing_errors_doc)]

mod board;
#[cfg(unix)]
pub mod console;
mod error;
mod idle_life;
mod journey;
mod line;
pub mod port;
pub mod pose;
mod servos;
mod telemetry_log;
mod upload;

pub use board::{Board, SILENCE, nonce};
pub use error::ClientError;
pub use idle_life::IdleLife;
pub use journey::{Arrival, Journey};
pub use line::{Line, SerialBoard};
pub use servos::BoardServos;
pub use telemetry_log::{TelemetryLog, TimedPose};
pub use upload::item;
