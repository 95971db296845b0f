//! A whole board in this program: the node that boards run, with flash in a file and simulated servos.
//!
//! ```text
//! client ─ bytes ─> SimulatedBoard: BackgroundTask ─ mail ─ ControlLoop ─> lines ─> simulated servos
//!                     └─ Chip (flash, a file keeps it)
//! ```
//! In simulated time the board is a [`Line`](sinew_board_client::Line) of the client. In real time
//! [`SimulatedBoard::serve`] connects it to a pseudo-terminal, or by [`pipe`] to a client in this program.

mod bus;
mod error;
mod flash;
mod node;
mod pipe;
mod serve;
mod simulated;
#[cfg(test)]
mod tests;
mod wiring;

pub use error::BoardError;
pub use flash::Chip;
pub use pipe::{BoardEnd, HostEnd, pipe};
pub use serve::HostSide;
pub use simulated::SimulatedBoard;
