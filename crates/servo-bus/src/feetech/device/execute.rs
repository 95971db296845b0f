//! Executes received packets and prepares the answers.

use super::{Device, Event, LONGEST, Turn};
use crate::feetech::frame::{BROADCAST, Packet};
use crate::feetech::instruction::{Instruction, sync_blocks};
use crate::feetech::status::Status;
use crate::feetech::table::{Family, address};
use crate::table::{Access, Item, Restriction};

/// Delay of a simulated answer to a broadcast ping, us per id, so that answers do not overlap. Answers of real servos
/// may collide.
const PING_SLOT_US: u32 = 1_000;

impl Device<'_> {
    fn id(&self) -> u8 {
        self.memory.get(usize::from(address::ID)).copied().unwrap_or(0)
    }

    pub(super) fn take(&mut self, packet: &Packet<'_>) {
        if let Some(turn) = self.turn.filter(|turn| turn.after == packet.id)
            && packet.params.len() == usize::from(turn.length)
        {
            self.turn = None;
            self.answer_read(turn.address, turn.length);
            return;
        }
        let own = self.id();
        let is_own = packet.id == own;
        // A packet with another id may be a reply of that servo: only an instruction to this servo ends its wait.
        if !is_own && packet.id != BROADCAST {
            return;
        }
        (self.turn, self.due_us) = (None, None);
        if let Some(instruction) = Instruction::decode(packet) {
            self.execute(instruction, is_own);
        }
    }

    fn execute(&mut self, instruction: Instruction<'_>, is_own: bool) {
        let own = self.id();
        match instruction {
            Instruction::Ping => {
                let slot_us = if is_own { 0 } else { u32::from(own).saturating_mul(PING_SLOT_US) };
                self.send(&[], slot_us);
            }
            Instruction::Read { address, length } if is_own => self.answer_read(address, length),
            Instruction::Read { .. } => {}
            Instruction::SyncRead { address, length, ids } => self.await_turn(address, length, ids),
            Instruction::SyncWrite { address, length, blocks } => {
                if let Some((_, data)) = sync_blocks(blocks, length).find(|(id, _)| *id == own) {
                    self.write(address, data);
                }
            }
            Instruction::Write { address, data } => {
                self.reply(is_own);
                self.write(address, data);
            }
            Instruction::RegWrite { address, data } => {
                self.registered.clear();
                let stored = self.registered.push(address).is_ok()
                    && self.registered.extend_from_slice(data).is_ok();
                self.set(address::REGISTERED, stored.into());
                self.reply(is_own);
            }
            Instruction::Action => {
                let registered = core::mem::take(&mut self.registered);
                if let Some((address, data)) = registered.split_first() {
                    self.write(*address, data);
                }
                self.set(address::REGISTERED, 0);
                self.reply(is_own);
            }
            Instruction::FactoryReset => {
                self.reply(is_own);
                self.reset_all(own);
                self.note(Event::FactoryReset);
            }
            Instruction::Reboot => {
                self.reboot();
                self.note(Event::Rebooted);
            }
            Instruction::ClearTurns => {
                self.note(Event::TurnsCleared);
                self.reply(is_own);
            }
            Instruction::SetPosition(position) => {
                let middle =
                    self.table.model.family.most_count().saturating_add(1).saturating_div(2);
                let order = self.table.model.family.order();
                let given = self
                    .table
                    .at(address::PRESENT_POSITION)
                    .map(|item| item.value(position, order));
                self.set_position(given.filter(|_| position.len() == 2).unwrap_or(middle));
                self.reply(is_own);
            }
        }
    }

    /// Writes bytes. Ignores bytes of read-only registers and refused values, without an error. A goal position
    /// switches torque on, and 128 in Torque Enable makes the present position the middle.
    fn write(&mut self, first: u8, data: &[u8]) {
        let is_open = self.get(self.table.model.family.lock()) == 0;
        for (to, byte) in (u16::from(first)..).zip(data) {
            let item = u8::try_from(to).ok().and_then(|to| self.table.at(to));
            if item.is_none_or(|item| {
                item.access == Access::ReadWrite && !self.refused(&item, first, data)
            }) {
                self.put(to.into(), *byte, is_open);
            }
        }
        let written = |address: u8| {
            address.checked_sub(first).is_some_and(|index| usize::from(index) < data.len())
        };
        if written(address::GOAL_POSITION) {
            self.set(address::TORQUE_ENABLE, 1);
        } else if written(address::TORQUE_ENABLE) && self.get(address::TORQUE_ENABLE) == 128 {
            self.set(address::TORQUE_ENABLE, 0);
            let middle = self.table.model.family.most_count().saturating_add(1).saturating_div(2);
            self.set_position(middle);
        }
        self.note(Event::Written {
            address: first,
            length: u8::try_from(data.len()).unwrap_or(u8::MAX),
        });
    }

    /// Returns whether the simulation refuses the value that a write would give to a register.
    fn refused(&self, item: &Item, first: u8, data: &[u8]) -> bool {
        let mut bytes = [0; 4];
        for (byte, at) in bytes.iter_mut().zip(item.address..item.end()) {
            let written = at.checked_sub(first.into()).and_then(|at| data.get(usize::from(at)));
            let kept = self.memory.get(usize::from(at));
            *byte = written.or(kept).copied().unwrap_or(0);
        }
        let value = item.value(&bytes, self.table.model.family.order());
        Restriction::refuse(self.restrictions, item.address, value)
    }

    /// Counts the present angle as `position`. An STS keeps the difference in its Homing Offset, also over a reboot.
    fn set_position(&mut self, position: i32) {
        let turn = self.table.model.family.most_count().saturating_add(1);
        let (present, offset) =
            (self.get(address::PRESENT_POSITION), self.get(address::HOMING_OFFSET));
        let turned = present.saturating_add(offset).saturating_sub(position).rem_euclid(turn);
        let is_behind = turned >= turn.saturating_div(2);
        let offset = if is_behind { turned.saturating_sub(turn) } else { turned };
        if self.table.model.family == Family::Sts {
            self.set(address::HOMING_OFFSET, offset);
            self.set(address::PRESENT_POSITION, position);
        }
        self.note(Event::PositionSet(position));
    }

    pub(super) fn put(&mut self, to: usize, byte: u8, is_stored: bool) {
        if let Some(slot) = self.memory.get_mut(to) {
            *slot = byte;
        }
        if is_stored && let Some(slot) = self.stored.get_mut(to) {
            *slot = byte;
        }
    }

    pub(super) fn reset_all(&mut self, id: u8) {
        let table = self.table;
        for item in table.items() {
            self.set(u8::try_from(item.address).unwrap_or(u8::MAX), item.initial);
        }
        self.set(address::ID, id.into());
    }

    fn reboot(&mut self) {
        let table = self.table;
        for item in table.items().filter(|item| item.address >= address::TORQUE_ENABLE.into()) {
            self.set(u8::try_from(item.address).unwrap_or(u8::MAX), item.initial);
        }
        for (slot, byte) in self.memory.iter_mut().zip(self.stored) {
            *slot = byte;
        }
        // By the maker's table, power-on copies the limit in EEPROM to the limit in RAM.
        if table.model.family == Family::Sts {
            self.set(address::TORQUE_LIMIT, self.get(address::MAX_TORQUE));
        }
    }

    fn await_turn(&mut self, address: u8, length: u8, ids: &[u8]) {
        let own = self.id();
        let Some(position) = ids.iter().position(|id| *id == own) else { return };
        match position.checked_sub(1).and_then(|before| ids.get(before)) {
            Some(&after) => self.turn = Some(Turn { after, address, length }),
            None => self.answer_read(address, length),
        }
    }

    pub(super) fn answer_read(&mut self, address: u8, length: u8) {
        let mut data = [0; 255];
        let bytes = self.memory.get(usize::from(address)..).unwrap_or_default();
        for (to, from) in data.iter_mut().zip(bytes) {
            *to = *from;
        }
        self.send(data.get(..usize::from(length)).unwrap_or_default(), 0);
    }

    fn reply(&mut self, is_own: bool) {
        if is_own && self.get(address::STATUS_LEVEL) != 0 {
            self.send(&[], 0);
        }
    }

    fn send(&mut self, data: &[u8], delay_us: u32) {
        let bits = u8::try_from(self.get(address::STATUS)).unwrap_or(0);
        let status = Status { id: self.id(), bits, data };
        let _ = self.answer.resize(LONGEST, 0);
        let len = status.encode(&mut self.answer);
        self.answer.truncate(len.unwrap_or(0));
        let return_delay_us = match self.table.model.family {
            Family::Sts => 0,
            Family::Scs => {
                u32::try_from(self.get(address::RETURN_DELAY)).unwrap_or(0).saturating_mul(2)
            }
        };
        self.due_us = len.ok().map(|_| return_delay_us.saturating_add(delay_us));
    }

    fn note(&mut self, event: Event) {
        if self.events.is_full() {
            self.events.pop_front();
        }
        let _ = self.events.push_back(event);
    }
}
