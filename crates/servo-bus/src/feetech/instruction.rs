//! What a controller asks of servos.

use super::frame::{BROADCAST, FrameWriter, MAX_ID, Packet};
use super::table::{Family, address};
use crate::EncodeError;

/// An instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Instruction<'a> {
    /// Who is there.
    Ping,
    /// Read so many bytes.
    Read {
        /// First address.
        address: u8,
        /// How many bytes.
        length: u8,
    },
    /// Write at once.
    Write {
        /// First address.
        address: u8,
        /// What to write.
        data: &'a [u8],
    },
    /// Write when [`Self::Action`] comes.
    RegWrite {
        /// First address.
        address: u8,
        /// What to write.
        data: &'a [u8],
    },
    /// Do what was registered.
    Action,
    /// Back to what the factory set, but for the id. [`Self::encode`] refuses it: see [`factory_reset`].
    FactoryReset,
    /// Start anew; not answered, takes about 0.8 s.
    Reboot,
    /// Forget full turns.
    ClearTurns,
    /// Make this the middle, or another position. [`Self::encode`] refuses it: see [`set_middle`].
    SetPosition(&'a [u8]),
    /// Read the same addresses of several servos; each answers by itself, in this order.
    SyncRead {
        /// First address.
        address: u8,
        /// Bytes of each servo.
        length: u8,
        /// The servos.
        ids: &'a [u8],
    },
    /// Write the same addresses of several servos; no one answers.
    SyncWrite {
        /// First address.
        address: u8,
        /// Bytes for each servo.
        length: u8,
        /// For each servo its id, and its bytes.
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

/// What Torque Enable takes for "this is the middle".
const MIDDLE: u8 = 128;

impl<'a> Instruction<'a> {
    /// Writes the packet, for servos of this family.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit; if it is for several servos and `id` is not [`BROADCAST`], or a read to
    /// all; if it would open the EEPROM, move the middle or reset the servo: there are calls for that by name.
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

    /// The instruction of a packet that was received; none if it is no instruction.
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

    /// Its byte on the wire.
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

/// Refuses what harms when it is written by accident.
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

/// Writes the packet after which EEPROM is stored, until 1 is written to the lock. Keep it shut in all normal use.
///
/// # Errors
/// [`EncodeError`] if it does not fit, or is for all servos.
pub fn open_eeprom(family: Family, id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::Write { address: family.lock(), data: &[0] }.write(id, out)
}

/// Writes the packet that makes where the servo stands its middle, 2048.
///
/// # Errors
/// [`EncodeError`] if it does not fit, or is for all servos.
pub fn set_middle(id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::Write { address: address::TORQUE_ENABLE, data: &[MIDDLE] }.write(id, out)
}

/// Writes the packet that sets a servo back to what it was at the factory, but for its id.
///
/// # Errors
/// [`EncodeError`] if it does not fit, or is for all servos.
pub fn factory_reset(id: u8, out: &mut [u8]) -> Result<usize, EncodeError> {
    if id > MAX_ID {
        return Err(EncodeError::Id(id));
    }
    Instruction::FactoryReset.write(id, out)
}

/// Writes a sync write, servo by servo, with the checks of [`Instruction::encode`].
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

    /// Adds a servo. Data of another length, or an id that no servo has, spoils the packet.
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

    /// Ends the packet, and says how long it is.
    ///
    /// # Errors
    /// [`EncodeError`] if it does not fit, or a servo was wrong.
    pub fn finish(self) -> Result<usize, EncodeError> {
        self.wrong.map_or_else(|| self.frame.finish(), Err)
    }
}

/// The servos of a sync write and their bytes; a rest that is too short is left out.
pub fn sync_blocks(blocks: &[u8], length: u8) -> impl Iterator<Item = (u8, &[u8])> {
    let each = usize::from(length).saturating_add(1);
    blocks.chunks_exact(each).filter_map(|block| block.split_first().map(|(id, data)| (*id, data)))
}
