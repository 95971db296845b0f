//! Instructions that a controller sends to servos.

use super::frame::{BROADCAST, FrameWriter, MAX_ID, Packet};
use super::table::{Family, address};
use crate::EncodeError;

/// An instruction. Lists stay encoded as on the wire.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Asks whether a servo is present.
    Ping,
    /// Reads `length` bytes.
    Read {
        /// First address to read.
        address: u8,
        /// Number of bytes to read.
        length: u8,
    },
    /// Writes at once.
    Write {
        /// First address to write.
        address: u8,
        /// Bytes to write.
        data: &'a [u8],
    },
    /// Registers a write, which is executed when [`Self::Action`] arrives.
    RegWrite {
        /// First address to write.
        address: u8,
        /// Bytes to write.
        data: &'a [u8],
    },
    /// Executes the registered write.
    Action,
    /// Resets to factory settings, except the id. [`Self::encode`] refuses it: use [`factory_reset`].
    FactoryReset,
    /// Restarts the servo, which takes about 0.8 s. The servo does not answer.
    Reboot,
    /// Clears full turns.
    ClearTurns,
    /// Declares the present angle to be the middle, or another position. [`Self::encode`] refuses it: use
    /// [`set_middle`].
    SetPosition(&'a [u8]),
    /// Reads the same addresses of several servos. Each servo answers with its own packet, in the order of `ids`.
    SyncRead {
        /// First address to read.
        address: u8,
        /// Number of bytes from each servo.
        length: u8,
        /// Ids of the servos.
        ids: &'a [u8],
    },
    /// Writes the same addresses of several servos. No servo answers.
    SyncWrite {
        /// First address to write.
        address: u8,
        /// Number of bytes for each servo.
        length: u8,
        /// For each servo its id, followed by its bytes.
        blocks: &'a [u8],
    },
}

mod code {
    pub(super) const PING: u8 = 0x01;
    pub(super) const READ: u8 = 0x02;
    pub(super) const WRITE: u8 = 0x03;
    pub(super) const REG_WRITE: u8 = 0x04;
    pub(super) const ACTION: u8 = 0x05;
    pub(super) const FACTORY_RESET: u8 = 0x06;
    pub(super) const REBOOT: u8 = 0x08;
    pub(super) const CLEAR_TURNS: u8 = 0x0A;
    pub(super) const SET_POSITION: u8 = 0x0B;
    pub(super) const SYNC_READ: u8 = 0x82;
    pub(super) const SYNC_WRITE: u8 = 0x83;
}

/// Value of Torque Enable that declares the present angle to be the middle.
const MIDDLE: u8 = 128;

impl<'a> Instruction<'a> {
    /// Writes the packet for servos of this family, and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`] if the packet does not fit; if the instruction is for several servos and `id` is not
    /// [`BROADCAST`]; if it is a read and `id` is [`BROADCAST`]; if it would open the EEPROM, move the middle or reset
    /// the servo: each of these has its own function.
    pub fn encode(&self, family: Family, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
        match *self {
            Self::FactoryReset => return Err(EncodeError::OnlyByName("factory_reset")),
            Self::SetPosition(_) => return Err(EncodeError::OnlyByName("set_middle")),
            Self::Write { address, data } | Self::RegWrite { address, data } => {
                guard(family, address, data)?;
            }
            Self::SyncWrite { address, length, blocks } => {
                sync_blocks(blocks, length)
                    .try_for_each(|(_, data)| guard(family, address, data))?;
            }
            _ => {}
        }
        self.write(id, out)
    }

    /// Decodes a received packet, or returns `None` if it is not a valid instruction.
    pub fn decode(packet: &Packet<'a>) -> Option<Self> {
        let params = packet.params;
        let written = || params.split_first();
        let group = || params.split_first_chunk::<2>();
        Some(match packet.code {
            code::PING => Self::Ping,
            code::READ => {
                let (&[address, length], _) = group()?;
                Self::Read { address, length }
            }
            code::WRITE => {
                written().map(|(address, data)| Self::Write { address: *address, data })?
            }
            code::REG_WRITE => {
                written().map(|(address, data)| Self::RegWrite { address: *address, data })?
            }
            code::ACTION => Self::Action,
            code::FACTORY_RESET => Self::FactoryReset,
            code::REBOOT => Self::Reboot,
            code::CLEAR_TURNS => Self::ClearTurns,
            code::SET_POSITION => Self::SetPosition(params),
            code::SYNC_READ => {
                let (&[address, length], ids) = group()?;
                Self::SyncRead { address, length, ids }
            }
            code::SYNC_WRITE => {
                let (&[address, length], blocks) = group()?;
                Self::SyncWrite { address, length, blocks }
            }
            _ => return None,
        })
    }

    /// Returns the instruction byte.
    pub const fn code(&self) -> u8 {
        match self {
            Self::Ping => code::PING,
            Self::Read { .. } => code::READ,
            Self::Write { .. } => code::WRITE,
            Self::RegWrite { .. } => code::REG_WRITE,
            Self::Action => code::ACTION,
            Self::FactoryReset => code::FACTORY_RESET,
            Self::Reboot => code::REBOOT,
            Self::ClearTurns => code::CLEAR_TURNS,
            Self::SetPosition(_) => code::SET_POSITION,
            Self::SyncRead { .. } => code::SYNC_READ,
            Self::SyncWrite { .. } => code::SYNC_WRITE,
        }
    }

    fn write(&self, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
        let is_group = matches!(self, Self::SyncRead { .. } | Self::SyncWrite { .. });
        let to_all = id == BROADCAST;
        if is_group != to_all && (is_group || matches!(self, Self::Read { .. })) {
            return Err(EncodeError::Id(id));
        }
        let mut frame = FrameWriter::new(out, id, self.code());
        match *self {
            Self::Ping | Self::Action | Self::FactoryReset | Self::Reboot | Self::ClearTurns => {}
            Self::Read { address, length } => frame.extend(&[address, length]),
            Self::Write { address, data } | Self::RegWrite { address, data } => {
                frame.extend(&[address]);
                frame.extend(data);
            }
            Self::SetPosition(position) => frame.extend(position),
            Self::SyncRead { address, length, ids: rest }
            | Self::SyncWrite { address, length, blocks: rest } => {
                frame.extend(&[address, length]);
                frame.extend(rest);
            }
        }
        frame.finish()
    }
}

/// Refuses writes that would harm if they happened by accident.
fn guard(family: Family, first: u8, data: &[u8]) -> Result<(), EncodeError> {
    let written =
        |address: u8| address.checked_sub(first).and_then(|index| data.get(usize::from(index)));
    if written(family.lock()) == Some(&0) {
        return Err(EncodeError::OnlyByName("open_eeprom"));
    }
    if written(address::TORQUE_ENABLE) == Some(&MIDDLE) {
        return Err(EncodeError::OnlyByName("set_middle"));
    }
    Ok(())
}

/// Writes the packet that opens the EEPROM: later writes are stored permanently, until 1 is written to the lock. Keep
/// the EEPROM shut in all normal use.
///
/// # Errors
/// [`EncodeError`] if the packet does not fit, or `id` is not the id of one servo.
pub fn open_eeprom(family: Family, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::Write { address: family.lock(), data: &[0] }.write(id, out)
}

/// Writes the packet that makes the servo's present angle its middle, 2048.
///
/// # Errors
/// [`EncodeError`] if the packet does not fit, or `id` is not the id of one servo.
pub fn set_middle(id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::Write { address: address::TORQUE_ENABLE, data: &[MIDDLE] }.write(id, out)
}

/// Writes the packet that resets a servo to its factory settings, except its id.
///
/// # Errors
/// [`EncodeError`] if the packet does not fit, or `id` is not the id of one servo.
pub fn factory_reset(id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::FactoryReset.write(id, out)
}

/// A writer of a sync write instruction, servo by servo, with the checks of [`Instruction::encode`].
pub struct SyncWriter<'a> {
    frame: FrameWriter<'a>,
    family: Family,
    address: u8,
    length: u8,
    wrong: Option<EncodeError>,
}

impl<'a> SyncWriter<'a> {
    /// Begins a sync write of `length` bytes for each servo.
    pub fn new(out: &'a mut [u8], family: Family, address: u8, length: u8) -> Self {
        let mut frame = FrameWriter::new(out, BROADCAST, code::SYNC_WRITE);
        frame.extend(&[address, length]);
        Self { frame, family, address, length, wrong: None }
    }

    /// Appends a servo. If the data have another length, no servo can have the id, or the write is dangerous,
    /// [`Self::finish`] fails.
    pub fn push(&mut self, id: u8, data: &[u8]) {
        if id > MAX_ID {
            self.wrong = Some(EncodeError::Id(id));
        }
        if data.len() != usize::from(self.length) {
            self.wrong = Some(EncodeError::Length);
        }
        if let Err(error) = guard(self.family, self.address, data) {
            self.wrong = Some(error);
        }
        self.frame.extend(&[id]);
        self.frame.extend(data);
    }

    /// Ends the packet and returns its length.
    ///
    /// # Errors
    /// [`EncodeError`] if the packet does not fit, or a servo was refused.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// Returns id and data of each servo in a sync write. Ignores an incomplete block at the end.
pub fn sync_blocks(blocks: &[u8], length: u8) -> impl Iterator<Item = (u8, &[u8])> {
    let each = usize::from(length).saturating_add(1);
    blocks.chunks_exact(each).filter_map(|block| block.split_first().map(|(id, data)| (*id, data)))
}
