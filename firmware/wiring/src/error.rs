//! Errors of a wiring.

use sinew_servo_bus::{ScheduleError, SetupError};
use thiserror::Error;

/// Version of the bytes, which the error names.
pub const VERSION: u8 = 2;

/// Why a wiring is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum WiringError {
    /// The bytes are no wiring of this version, or not all of it.
    #[error("not a wiring of version {VERSION}")]
    Bytes,
    /// There are too many servos.
    #[error("the board holds {holds} servos; the wiring has more")]
    Servos {
        /// How many the board holds.
        holds: usize,
    },
    /// There are too many lines, none, or a servo or the loop is on one that there is not.
    #[error(
        "the wiring has no line, too many lines for this board, or servos on a line that does not exist"
    )]
    Line,
    /// A Dynamixel is of no model in the table.
    #[error("servo {id} is a Dynamixel of model {found}, which is not in the table")]
    Model {
        /// Its id.
        id: u8,
        /// Its number.
        found: u16,
    },
    /// A servo is on a line of another maker's.
    #[error("a servo is on a line of another protocol")]
    Protocol,
    /// The chip's clock cannot be divided so.
    #[error("a PCA9685 makes 24 to 1526 pulses a second at 25 MHz")]
    Pulses,
    /// A line is too slow.
    #[error(transparent)]
    Schedule(ScheduleError),
    /// A servo's setting.
    #[error(transparent)]
    Setup(SetupError),
}
