//! Replies of servos.

use super::frame::{FrameWriter, Packet, STATUS};
use crate::EncodeError;

/// The error byte of a reply: a number, and a bit for trouble of the hardware.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct StatusError(u8);

const ALERT: u8 = 0x80;

impl StatusError {
    /// No error.
    pub const NONE: Self = Self(0);

    /// The error byte of the wire.
    pub const fn from_byte(byte: u8) -> Self {
        Self(byte)
    }

    /// An error of this number, or none.
    pub fn new(code: Option<ErrorCode>, alert: bool) -> Self {
        Self(code.map_or(0, ErrorCode::number) | if alert { ALERT } else { 0 })
    }

    /// The byte on the wire.
    pub const fn byte(self) -> u8 {
        self.0
    }

    /// Whether Hardware Error Status (70) says what is wrong.
    pub const fn alert(self) -> bool {
        self.0 & ALERT != 0
    }

    /// What became of the instruction, if it failed.
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

/// Why a servo did not do what an instruction says. A number, not a set of bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ErrorCode {
    /// 1: it could not be done.
    ResultFail,
    /// 2: no such instruction, or action without a registered write.
    Instruction,
    /// 3: the CRC of the packet was wrong.
    Crc,
    /// 4: the value is outside of its range.
    DataRange,
    /// 5: fewer bytes than the item has.
    DataLength,
    /// 6: the value is outside of a limit that another item sets.
    DataLimit,
    /// 7: read-only, undefined, or EEPROM while torque is on.
    Access,
    /// A number that the protocol does not define.
    Unknown(u8),
}

impl ErrorCode {
    /// The number on the wire.
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

/// Hardware Error Status (70), bit by bit. Only a reboot clears it.
pub mod hardware_error {
    /// The supply is outside of its limits.
    pub const INPUT_VOLTAGE: u8 = 1 << 0;
    /// The case is too hot.
    pub const OVERHEATING: u8 = 1 << 2;
    /// The motor's encoder.
    pub const ENCODER: u8 = 1 << 3;
    /// An electrical shock, or too little power.
    pub const SHOCK: u8 = 1 << 4;
    /// Load for too long.
    pub const OVERLOAD: u8 = 1 << 5;
}

/// The reply of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status<'a> {
    /// Whose reply.
    pub id: u8,
    /// What became of the instruction.
    pub error: StatusError,
    /// What was read; model and firmware of a ping.
    pub data: &'a [u8],
}

impl<'a> Status<'a> {
    /// The packet as a reply, if it is one.
    pub fn of(packet: Packet<'a>) -> Option<Self> {
        let (error, data) = packet.params.split_first()?;
        let error = StatusError::from_byte(*error);
        (packet.instruction == STATUS).then_some(Self { id: packet.id, error, data })
    }

    /// Writes the reply.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut frame = FrameWriter::new(out, self.id, STATUS);
        frame.push(self.error.byte());
        frame.extend(self.data);
        frame.finish()
    }

    /// Whether this is what servo `id` answers to a request for `len` bytes: all of them, or none and an error.
    pub fn answers(&self, id: u8, len: usize) -> bool {
        let refused = self.data.is_empty() && self.error.code().is_some();
        self.id == id && (self.data.len() == len || refused)
    }
}
