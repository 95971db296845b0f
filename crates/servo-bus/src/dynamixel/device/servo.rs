//! Executes received packets and prepares the answers.

use heapless::{Deque, Vec};

use super::event::Event;
use super::memory::Memory;
use super::turn::Turn;
use crate::EncodeError;
use crate::dynamixel::frame::{BROADCAST, MAX_ID, Packet, STATUS};
use crate::dynamixel::group::{bulk_blocks, sync_blocks};
use crate::dynamixel::instruction::Instruction;
use crate::dynamixel::status::{ErrorCode, Status, StatusError};
use crate::dynamixel::table::address;

/// All state of a simulated servo except its parser, which lends it packets.
pub(super) struct Servo<'m, const N: usize> {
    pub(super) memory: Memory<'m>,
    pub(super) turn: Option<Turn>,
    /// Address and data of a registered write, which waits for an Action instruction.
    pub(super) registered: Vec<u8, N>,
    pub(super) answer: Vec<u8, N>,
    pub(super) due_us: Option<u32>,
    pub(super) silent_us: u32,
    pub(super) events: Deque<Event, 8>,
}

/// The lowest status level at which an instruction is answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Answers {
    Ping,
    Reads,
    All,
}

impl<const N: usize> Servo<'_, N> {
    pub(super) fn id(&self) -> u8 {
        u8::try_from(self.memory.get(address::ID)).unwrap_or(0)
    }

    pub(super) fn note(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }

    pub(super) fn take(&mut self, packet: &Packet<'_>) {
        if packet.instruction == STATUS {
            self.hear_status(packet.id);
            return;
        }
        self.silent_us = 0;
        (self.turn, self.due_us) = (None, None);
        let own = self.id();
        // Several servos may share a secondary id: each obeys it, and none answers.
        let shadow =
            self.memory.get(address::SECONDARY_ID) == i32::from(packet.id) && packet.id <= MAX_ID;
        if packet.id != own && packet.id != BROADCAST && !shadow {
            return;
        }
        let is_own = packet.id == own;
        let instruction = match Instruction::decode(packet) {
            Ok(instruction) => instruction,
            Err(_) if !is_own => return,
            Err(code) => return self.reply(Answers::All, Err(code)),
        };
        self.execute(instruction, is_own);
    }

    fn execute(&mut self, instruction: Instruction<'_>, is_own: bool) {
        let done = match instruction {
            Instruction::Ping => {
                self.answer_ping(is_own);
                return;
            }
            Instruction::Read { address, length } if is_own => {
                self.answer_read(address, length, self.return_delay_us());
                return;
            }
            Instruction::Read { .. } => return,
            Instruction::SyncRead(span) | Instruction::FastSyncRead(span) => {
                let is_fast = matches!(instruction, Instruction::FastSyncRead(_));
                return self.await_turn(Turn::of_sync(&span, self.id(), is_fast));
            }
            Instruction::BulkRead(list) | Instruction::FastBulkRead(list) => {
                let is_fast = matches!(instruction, Instruction::FastBulkRead(_));
                return self.await_turn(Turn::of_bulk(list, self.id(), is_fast));
            }
            Instruction::Write { address, data } => self.write(address, data),
            Instruction::SyncWrite { address, length, blocks } => {
                let own = self.id();
                let data = sync_blocks(blocks, length).find(|(id, _)| *id == own);
                data.map_or(Ok(()), |(_, data)| self.write(address, data))
            }
            Instruction::BulkWrite(list) => {
                let own = self.id();
                let block = bulk_blocks(list).find(|(id, ..)| *id == own);
                block.map_or(Ok(()), |(_, address, data)| self.write(address, data))
            }
            Instruction::RegWrite { address, data } => self.register(address, data),
            Instruction::Action => self.act(),
            Instruction::Reboot | Instruction::FactoryReset(_) => Ok(()),
            Instruction::ClearTurns if self.memory.get(address::MOVING) != 0 => {
                Err(ErrorCode::ResultFail)
            }
            Instruction::ClearTurns => {
                let within = self.memory.get(address::PRESENT_POSITION).rem_euclid(4096);
                self.memory.set(address::PRESENT_POSITION, within);
                self.note(Event::TurnsCleared);
                Ok(())
            }
        };
        let own = self.id();
        if is_own && !instruction.is_group() {
            // A new id is valid from the next packet on: this answer still has the old one.
            self.reply(Answers::All, done);
        }
        match instruction {
            Instruction::Reboot => {
                self.memory.reset_ram();
                self.note(Event::Rebooted);
            }
            Instruction::FactoryReset(scope) => {
                self.memory.factory_reset(scope, own);
                self.note(Event::FactoryReset);
            }
            _ => {}
        }
    }

    fn write(&mut self, address: u16, data: &[u8]) -> Result<(), ErrorCode> {
        self.memory.write(address, data)?;
        let length = u16::try_from(data.len()).unwrap_or(u16::MAX);
        self.note(Event::Written { address, length });
        Ok(())
    }

    fn register(&mut self, address: u16, data: &[u8]) -> Result<(), ErrorCode> {
        self.memory.check(address, data)?;
        self.registered.clear();
        let stored = self.registered.extend_from_slice(&address.to_le_bytes()).is_ok()
            && self.registered.extend_from_slice(data).is_ok();
        self.memory.set(address::REGISTERED, stored.into());
        if stored { Ok(()) } else { Err(ErrorCode::DataLength) }
    }

    fn act(&mut self) -> Result<(), ErrorCode> {
        if self.memory.get(address::REGISTERED) == 0 {
            return Err(ErrorCode::Instruction);
        }
        self.memory.set(address::REGISTERED, 0);
        let registered = core::mem::take(&mut self.registered);
        let Some((address, data)) = registered.split_first_chunk::<2>() else { return Ok(()) };
        self.write(u16::from_le_bytes(*address), data).map_err(|_| ErrorCode::ResultFail)
    }

    fn answer_ping(&mut self, is_own: bool) {
        let mut data = [0; 3];
        self.memory.copy(address::MODEL_NUMBER, data.get_mut(..2).unwrap_or_default());
        self.memory.copy(address::FIRMWARE, data.get_mut(2..).unwrap_or_default());
        // All servos answer a broadcast ping, one after the other: each id has its own time slot.
        let slot_us = if is_own { 0 } else { u32::from(self.id()).saturating_mul(PING_SLOT_US) };
        self.send(&data, Answers::Ping, Ok(()), self.return_delay_us().saturating_add(slot_us));
    }

    pub(super) fn reply(&mut self, answers: Answers, done: Result<(), ErrorCode>) {
        self.send(&[], answers, done, self.return_delay_us());
    }

    pub(super) fn send(
        &mut self,
        data: &[u8],
        answers: Answers,
        done: Result<(), ErrorCode>,
        delay_us: u32,
    ) {
        let level = match self.memory.get(address::STATUS_LEVEL) {
            0 => Answers::Ping,
            1 => Answers::Reads,
            _ => Answers::All,
        };
        if answers > level {
            return;
        }
        let status = Status { id: self.id(), error: self.error(done.err()), data };
        self.encode(delay_us, |out| status.encode(out));
    }

    pub(super) fn error(&self, code: Option<ErrorCode>) -> StatusError {
        StatusError::new(code, self.memory.get(address::HARDWARE_ERROR) != 0)
    }

    /// Prepares an answer. If the answer does not fit, the servo stays silent.
    pub(super) fn encode(
        &mut self,
        delay_us: u32,
        write: impl FnOnce(&mut [u8]) -> Result<usize, EncodeError>,
    ) {
        let _ = self.answer.resize(N, 0);
        match write(&mut self.answer) {
            Ok(len) => {
                self.answer.truncate(len);
                self.due_us = Some(delay_us);
            }
            Err(_) => self.due_us = None,
        }
    }

    pub(super) fn return_delay_us(&self) -> u32 {
        u32::try_from(self.memory.get(address::RETURN_DELAY)).unwrap_or(0).saturating_mul(2)
    }
}

/// Time slot of one id for the answers to a broadcast ping, us. ROBOTIS's client waits 3 ms for each id:
/// `dynamixel-sdk` 4.1.0.
const PING_SLOT_US: u32 = 3_000;
