//! Replies of servos.

use super::frame::{FrameWriter, Packet, STATUS};
use crate::EncodeError;

/// Error byte of a reply: an error number, and a bit for a hardware error.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatusError(u8);

const ALERT: u8 = 0x80;

impl StatusError {
    /// The error byte of a successful instruction.
    pub const NONE: Self = Self(0);

    /// Wraps an error byte from the wire.
    pub const fn from_byte(byte: u8) -> Self {
        Self(byte)
    }

    /// Creates an error byte from an error number and the hardware alert.
    pub fn new(code: Option<ErrorCode>, alert: bool) -> Self {
        Self(code.map_or(0, ErrorCode::number) | if alert { ALERT } else { 0 })
    }

    /// Returns the byte as on the wire.
    pub const fn byte(self) -> u8 {
        self.0
    }

    /// Returns whether the servo has a hardware error; Hardware Error Status (70) says which.
    pub const fn alert(self) -> bool {
        self.0 & ALERT != 0
    }

    /// Returns the error number, or `None` if the instruction succeeded.
    pub const fn code(self) -> Option<ErrorCode> {
        Some(match self.0 & !ALERT {
            0 => return None,
            1 => ErrorCode::ResultFail,
            2 => ErrorCode::Instruction,
            3 => ErrorCode::Crc,
            4 => ErrorCode::DataRange,
            5 => ErrorCode::DataLength,
            6 => ErrorCode::DataLimit,
            7 => ErrorCode::Access,
            other => ErrorCode::Unknown(other),
        })
    }
}

/// The reason why a servo refused an instruction: a number, not a set of bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCode {
    /// Error 1: the instruction failed.
    ResultFail,
    /// Error 2: the instruction is unknown, or an action arrived without a registered write.
    Instruction,
    /// Error 3: the CRC of the packet was wrong.
    Crc,
    /// Error 4: the value is outside of the register's range.
    DataRange,
    /// Error 5: fewer bytes were written than the register has.
    DataLength,
    /// Error 6: the value exceeds a limit that another register sets.
    DataLimit,
    /// Error 7: the register is read-only or undefined, or is in EEPROM while torque is on.
    Access,
    /// A number that the protocol does not define.
    Unknown(u8),
}

impl ErrorCode {
    /// Returns the number as on the wire.
    pub const fn number(self) -> u8 {
        match self {
            Self::ResultFail => 1,
            Self::Instruction => 2,
            Self::Crc => 3,
            Self::DataRange => 4,
            Self::DataLength => 5,
            Self::DataLimit => 6,
            Self::Access => 7,
            Self::Unknown(number) => number & !ALERT,
        }
    }
}

/// The bits of Hardware Error Status (70). Only a reboot clears them.
pub mod hardware_error {
    /// The supply is outside of its limits.
    pub const INPUT_VOLTAGE: u8 = 1 << 0;
    /// The case is too hot.
    pub const OVERHEATING: u8 = 1 << 2;
    /// The motor's encoder fails.
    pub const ENCODER: u8 = 1 << 3;
    /// An electrical shock occurred, or the power is too low.
    pub const SHOCK: u8 = 1 << 4;
    /// The load was too high for too long.
    pub const OVERLOAD: u8 = 1 << 5;
}

/// The reply of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status<'a> {
    /// Id of the servo that replied.
    pub id: u8,
    /// Error byte of the reply.
    pub error: StatusError,
    /// The bytes that were read; for a ping, model number and firmware version.
    pub data: &'a [u8],
}

impl<'a> Status<'a> {
    /// Interprets a packet as a reply, or returns `None` if it is not a reply.
    pub fn of(packet: Packet<'a>) -> Option<Self> {
        let (error, data) = packet.params.split_first()?;
        let error = StatusError::from_byte(*error);
        (packet.instruction == STATUS).then_some(Self { id: packet.id, error, data })
    }

    /// Writes the reply.
    ///
    /// # Errors
    /// [`EncodeError`] if the reply does not fit in `out`.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut frame = FrameWriter::new(out, self.id, STATUS);
        frame.push(self.error.byte());
        frame.extend(self.data);
        frame.finish()
    }

    /// Returns whether this is a valid answer of servo `id` to a request for `len` bytes: all bytes, or no bytes and an
    /// error.
    pub fn answers(&self, id: u8, len: usize) -> bool {
        let refused = self.data.is_empty() && self.error.code().is_some();
        self.id == id && (self.data.len() == len || refused)
    }
}
