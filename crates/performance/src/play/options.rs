//! Choices of the user for a rig that plays.

use super::servo_part::Drive;

/// Choices of a play. Default: what each servo can do, and the lines have time for.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    /// How servos are driven.
    pub drive: Option<Drive>,
    /// Ticks a second.
    pub rate_hz: Option<u32>,
    /// Bits a second of all lines.
    pub baud: Option<u32>,
    /// For a board, in place of a loop in this program: what the board's processor computes in a tick counts, and its
    /// clock divides to the rate of its lines.
    pub is_of_board: bool,
}

impl Options {
    /// Returns the options of a board, with nothing else chosen.
    pub fn of_board() -> Self {
        Self { is_of_board: true, ..Self::default() }
    }
}
