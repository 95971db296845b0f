//! The user's options for a rig that plays.

use super::servo_part::Drive;

/// Options for playing. Default: the default drive of each servo, and the highest usual rate for which the lines have
/// time.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Options {
    /// Drive of the servos; `None`: the default of each servo.
    pub drive: Option<Drive>,
    /// Tick rate, Hz; `None`: the highest usual rate for which the lines have time.
    pub rate_hz: Option<u32>,
    /// Rate of all lines except those of PCA9685, bit/s; `None`: the usual rate of each line.
    pub baud: Option<u32>,
    /// Whether the loop runs on a board. If so, the computing time of the board's processor in a tick counts, and a
    /// divisor of its clock must give the rate of the lines.
    pub is_of_board: bool,
}

impl Options {
    /// Returns the options of a board; all others have their defaults.
    pub fn of_board() -> Self {
        Self { is_of_board: true, ..Self::default() }
    }
}
