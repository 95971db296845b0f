//! Instructions that a controller sends to servos.

use super::frame::{BROADCAST, FrameWriter, Packet};
use super::status::ErrorCode;
use crate::EncodeError;

/// An instruction. Lists stay encoded as on the wire: [`super::group`] writes and reads them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Asks whether a servo is present. Answered at every status level.
    Ping,
    /// Reads `length` bytes.
    Read {
        /// First address to read.
        address: u16,
        /// Number of bytes to read.
        length: u16,
    },
    /// Writes at once.
    Write {
        /// First address to write.
        address: u16,
        /// Bytes to write.
        data: &'a [u8],
    },
    /// Registers a write, which is executed when [`Self::Action`] arrives.
    RegWrite {
        /// First address to write.
        address: u16,
        /// Bytes to write.
        data: &'a [u8],
    },
    /// Executes the registered write.
    Action,
    /// Resets to factory settings. [`Self::encode`] refuses it: use [`factory_reset`].
    FactoryReset(ResetScope),
    /// Restarts the servo. Only this clears a hardware error.
    Reboot,
    /// Clears full turns, so that the position is within one turn. Fails while the servo moves.
    ClearTurns,
    /// Reads the same addresses of several servos. Each servo answers with its own packet.
    SyncRead(Span<'a>),
    /// Reads the same addresses of several servos. All answer in one packet.
    FastSyncRead(Span<'a>),
    /// Writes the same addresses of several servos. No servo answers.
    SyncWrite {
        /// First address to write.
        address: u16,
        /// Number of bytes for each servo.
        length: u16,
        /// For each servo its id, followed by its bytes.
        blocks: &'a [u8],
    },
    /// Reads addresses that may differ between servos. For each servo: id, address and length, 5 bytes.
    BulkRead(&'a [u8]),
    /// Like [`Self::BulkRead`], but all servos answer in one packet.
    FastBulkRead(&'a [u8]),
    /// Writes addresses that may differ between servos. For each servo: id, address, length, and the bytes.
    BulkWrite(&'a [u8]),
}

/// A range of addresses that is read from several servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span<'a> {
    /// First address to read.
    pub address: u16,
    /// Number of bytes from each servo.
    pub length: u16,
    /// Ids of the servos, in the order of their answers.
    pub ids: &'a [u8],
}

/// The settings that a factory reset clears.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetScope {
    /// All settings: afterwards the servo has id 1 and 57,600 baud.
    All,
    /// All settings but the id.
    ButId,
    /// All settings but id and baud rate.
    ButIdAndBaud,
}

const CLEAR_TURNS: [u8; 5] = [0x01, 0x44, 0x58, 0x4C, 0x22];

impl<'a> Instruction<'a> {
    /// Writes the packet and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`] if the packet does not fit; if the instruction is for several servos and `id` is not
    /// [`BROADCAST`]; if it is a read and `id` is [`BROADCAST`]; if it is a factory reset.
    pub fn encode(&self, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
        if matches!(self, Self::FactoryReset(_)) {
            return Err(EncodeError::OnlyByName("factory_reset"));
        }
        self.write(id, out)
    }

    /// Decodes a received packet.
    ///
    /// # Errors
    /// The error that a servo answers to a packet with an unknown instruction or too few parameters.
    pub fn decode(packet: &Packet<'a>) -> Result<Self, ErrorCode> {
        let params = packet.params;
        let span = || {
            let (address, length, ids) = two_u16(params)?;
            Some(Span { address, length, ids })
        };
        let write = || params.split_first_chunk::<2>();
        let instruction = match packet.instruction {
            code::PING => Some(Self::Ping),
            code::READ => {
                two_u16(params).map(|(address, length, _)| Self::Read { address, length })
            }
            code::WRITE => write()
                .map(|(address, data)| Self::Write { address: u16::from_le_bytes(*address), data }),
            code::REG_WRITE => write().map(|(address, data)| Self::RegWrite {
                address: u16::from_le_bytes(*address),
                data,
            }),
            code::ACTION => Some(Self::Action),
            code::FACTORY_RESET => {
                params.first().and_then(|scope| ResetScope::of(*scope)).map(Self::FactoryReset)
            }
            code::REBOOT => Some(Self::Reboot),
            code::CLEAR => (params == CLEAR_TURNS).then_some(Self::ClearTurns),
            code::SYNC_READ => span().map(Self::SyncRead),
            code::FAST_SYNC_READ => span().map(Self::FastSyncRead),
            code::SYNC_WRITE => two_u16(params).map(|(address, length, blocks)| Self::SyncWrite {
                address,
                length,
                blocks,
            }),
            code::BULK_READ => Some(Self::BulkRead(params)),
            code::FAST_BULK_READ => Some(Self::FastBulkRead(params)),
            code::BULK_WRITE => Some(Self::BulkWrite(params)),
            _ => return Err(ErrorCode::Instruction),
        };
        instruction.ok_or(ErrorCode::DataLength)
    }

    /// Returns the instruction byte.
    pub const fn code(&self) -> u8 {
        match self {
            Self::Ping => code::PING,
            Self::Read { .. } => code::READ,
            Self::Write { .. } => code::WRITE,
            Self::RegWrite { .. } => code::REG_WRITE,
            Self::Action => code::ACTION,
            Self::FactoryReset(_) => code::FACTORY_RESET,
            Self::Reboot => code::REBOOT,
            Self::ClearTurns => code::CLEAR,
            Self::SyncRead(_) => code::SYNC_READ,
            Self::FastSyncRead(_) => code::FAST_SYNC_READ,
            Self::SyncWrite { .. } => code::SYNC_WRITE,
            Self::BulkRead(_) => code::BULK_READ,
            Self::FastBulkRead(_) => code::FAST_BULK_READ,
            Self::BulkWrite(_) => code::BULK_WRITE,
        }
    }

    /// Returns whether one packet with this instruction is for several servos.
    pub const fn is_group(&self) -> bool {
        matches!(
            self,
            Self::SyncRead(_)
                | Self::FastSyncRead(_)
                | Self::SyncWrite { .. }
                | Self::BulkRead(_)
                | Self::FastBulkRead(_)
                | Self::BulkWrite(_)
        )
    }

    fn write(&self, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
        let to_all = id == BROADCAST;
        if self.is_group() != to_all && (self.is_group() || matches!(self, Self::Read { .. })) {
            return Err(EncodeError::Id(id));
        }
        let mut frame = FrameWriter::new(out, id, self.code());
        match *self {
            Self::Ping | Self::Action | Self::Reboot => {}
            Self::Read { address, length } => {
                frame.push_u16(address);
                frame.push_u16(length);
            }
            Self::Write { address, data } | Self::RegWrite { address, data } => {
                frame.push_u16(address);
                frame.extend(data);
            }
            Self::FactoryReset(scope) => frame.push(scope.byte()),
            Self::ClearTurns => frame.extend(&CLEAR_TURNS),
            Self::SyncRead(Span { address, length, ids: rest })
            | Self::FastSyncRead(Span { address, length, ids: rest })
            | Self::SyncWrite { address, length, blocks: rest } => {
                frame.push_u16(address);
                frame.push_u16(length);
                frame.extend(rest);
            }
            Self::BulkRead(rest) | Self::FastBulkRead(rest) | Self::BulkWrite(rest) => {
                frame.extend(rest);
            }
        }
        frame.finish()
    }
}

/// Writes a factory reset. The servo loses its settings, and afterwards may have id 1 and another baud rate.
///
/// # Errors
/// [`EncodeError`] if the packet does not fit, or if it is a broadcast that resets all settings: afterwards all
/// servos would have id 1.
pub fn factory_reset(id: u8, scope: ResetScope, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id == BROADCAST && scope == ResetScope::All {
        return Err(EncodeError::Id(id));
    }
    Instruction::FactoryReset(scope).write(id, out)
}

impl ResetScope {
    const fn byte(self) -> u8 {
        match self {
            Self::All => 0xFF,
            Self::ButId => 0x01,
            Self::ButIdAndBaud => 0x02,
        }
    }

    const fn of(byte: u8) -> Option<Self> {
        match byte {
            0xFF => Some(Self::All),
            0x01 => Some(Self::ButId),
            0x02 => Some(Self::ButIdAndBaud),
            _ => None,
        }
    }
}

fn two_u16(params: &[u8]) -> Option<(u16, u16, &[u8])> {
    let (&[a, b, c, d], rest) = params.split_first_chunk::<4>()?;
    Some((u16::from_le_bytes([a, b]), u16::from_le_bytes([c, d]), rest))
}

/// Instruction bytes. Source: e-manual, protocol 2.0. Source of the fast instructions: npm `dynamixel` 0.1.0,
/// `dynamixel-sdk` 4.1.0.
mod code {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const WRITE: u8 = 0x03;
    pub(super) const REG_WRITE: u8 = 0x04;
    pub(super) const ACTION: u8 = 0x05;
    pub(super) const FACTORY_RESET: u8 = 0x06;
    pub(super) const REBOOT: u8 = 0x08;
    pub(super) const CLEAR: u8 = 0x10;
    pub(super) const SYNC_READ: u8 = 0x82;
    pub(super) const SYNC_WRITE: u8 = 0x83;
    pub(super) const FAST_SYNC_READ: u8 = 0x8A;
    pub(super) const BULK_READ: u8 = 0x92;
    pub(super) const BULK_WRITE: u8 = 0x93;
    pub(super) const FAST_BULK_READ: u8 = 0x9A;
}
