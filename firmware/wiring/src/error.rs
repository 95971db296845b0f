//! Errors of a wiring.

use sinew_servo_bus::{ScheduleError, SetupError};
use thiserror::Error;

/// Version of a wiring's byte format.
pub const VERSION: u8 = 2;

/// A reason for which a wiring is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WiringError {
    /// The bytes are not a complete wiring of this version.
    #[error("not a wiring of version {VERSION}")]
    Bytes,
    /// There are more servos than the board holds.
    #[error("the board holds {holds} servos; the wiring has more")]
    Servos {
        /// Maximum number of servos on the board.
        holds: usize,
    },
    /// There are too many lines, no lines, or a servo or the loop refers to a line that does not exist.
    #[error(
        "the wiring has no line, too many lines for this board, or servos on a line that does not exist"
    )]
    Line,
    /// A Dynamixel has a model that is not in the table.
    #[error("servo {id} is a Dynamixel of model {found}, which is not in the table")]
    Model {
        /// Bus ID of the servo.
        id: u8,
        /// Model number of the servo.
        found: u16,
    },
    /// A servo is on a line with another maker's protocol.
    #[error("a servo is on a line of another protocol")]
    Protocol,
    /// The chip's clock cannot be divided to the requested pulse rate.
    #[error("a PCA9685 makes 24 to 1526 pulses a second at 25 MHz")]
    Pulses,
    /// A line is too slow for the rate of the loop.
    #[error(transparent)]
    Schedule(ScheduleError),
    /// A setting of a servo is invalid.
    #[error(transparent)]
    Setup(SetupError),
}
