//! What a controller asks of servos.

use super::frame::{BROADCAST, FrameWriter, Packet};
use super::status::ErrorCode;
use crate::EncodeError;

/// An instruction. Lists stay as they are on the wire: [`super::group`] writes and reads them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Who is there; answered at every status level.
    Ping,
    /// Read so many bytes.
    Read {
        /// First address.
        address: u16,
        /// How many bytes.
        length: u16,
    },
    /// Write at once.
    Write {
        /// First address.
        address: u16,
        /// What to write.
        data: &'a [u8],
    },
    /// Write when [`Self::Action`] comes.
    RegWrite {
        /// First address.
        address: u16,
        /// What to write.
        data: &'a [u8],
    },
    /// Do what was registered.
    Action,
    /// Back to what the factory set. [`Self::encode`] refuses it: see [`factory_reset`].
    FactoryReset(ResetScope),
    /// Start anew. The only way out of a hardware error.
    Reboot,
    /// Forget full turns, so that the position is within one. Fails while the servo moves.
    ClearTurns,
    /// Read the same addresses of several servos; each answers by itself.
    SyncRead(Span<'a>),
    /// The same, but all answer in one packet.
    FastSyncRead(Span<'a>),
    /// Write the same addresses of several servos; no one answers.
    SyncWrite {
        /// First address.
        address: u16,
        /// Bytes for each servo.
        length: u16,
        /// For each servo its id, and its bytes.
        blocks: &'a [u8],
    },
    /// Read other addresses of each servo: for each id, address and length, 5 bytes.
    BulkRead(&'a [u8]),
    /// The same, but all answer in one packet.
    FastBulkRead(&'a [u8]),
    /// Write other addresses of each servo: for each id, address, length, and the bytes.
    BulkWrite(&'a [u8]),
}

/// The same addresses of several servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span<'a> {
    /// First address.
    pub address: u16,
    /// Bytes of each servo.
    pub length: u16,
    /// The servos, in the order of their answers.
    pub ids: &'a [u8],
}

/// How much a factory reset forgets.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ResetScope {
    /// Everything: afterwards it is servo 1 at 57,600 baud.
    All,
    /// All but the id.
    ButId,
    /// All but id and baud.
    ButIdAndBaud,
}

const CLEAR_TURNS: [u8; 5] = [0x01, 0x44, 0x58, 0x4C, 0x22];

impl<'a> Instruction<'a> {
    /// Writes the packet.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit; if it is for a group and `id` is not [`BROADCAST`], or a read to all; if it
    /// is a factory reset.
    pub fn encode(&self, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
        if matches!(self, Self::FactoryReset(_)) {
            return Err(EncodeError::OnlyByName("factory_reset"));
        }
        self.write(id, out)
    }

    /// The instruction of a packet that was received.
    ///
    /// # Errors
    /// What a servo answers to a packet that is no instruction, or whose parameters are too few.
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

    /// Its byte on the wire.
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

    /// Whether one packet of it is for several servos.
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

/// Writes a factory reset: the servo forgets its settings, and may afterwards listen as servo 1 at another baud.
///
/// # Errors
/// [`EncodeError`] if it does not fit. Reset of everything cannot be broadcast: all servos would be servo 1.
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

/// Instruction bytes. Source: e-manual, protocol 2.0; the fast ones: npm `dynamixel` 0.1.0, `dynamixel-sdk` 4.1.0.
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
