//! A whole board in this program: the node that boards run, with flash in a file and simulated servos.
//!
//! ```text
//! client ─ bytes ─> SimulatedBoard: BackgroundTask ─ mail ─ ControlLoop ─> lines ─> simulated servos
//!                     └─ Chip (flash, a file keeps it)
//! ```
//! In simulated time it is a [`Line`](sinew_board_client::Line) of the client, in real time [`SimulatedBoard::serve`] puts it
//! on a pseudo-terminal.

mod bus;
mod error;
mod flash;
mod node;
#[cfg(unix)]
mod serve;
mod simulated;
#[cfg(test)]
mod tests;
mod wiring;

pub use error::BoardError;
pub use flash::Chip;
pub use simulated::SimulatedBoard;
