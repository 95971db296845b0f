//! Answers reads: at once, or in turn with other servos.

use super::servo::{Answers, Servo};
use super::turn::{After, Turn};
use crate::dynamixel::status::{ErrorCode, Status};
use crate::dynamixel::table::address;

/// Maximum bytes of one read: a whole table.
const READ_LEN: usize = 662;

impl<const N: usize> Servo<'_, N> {
    pub(super) fn answer_read(&mut self, address: u16, length: u16, delay_us: u32) {
        let mut data = [0; READ_LEN];
        let read = match data.get_mut(..usize::from(length)) {
            Some(data) => self.memory.read(address, data),
            None => Err(ErrorCode::DataLength),
        };
        let data = data.get(..usize::from(length)).filter(|_| read.is_ok()).unwrap_or_default();
        self.send(data, Answers::Reads, read, delay_us);
    }

    pub(super) fn await_turn(&mut self, turn: Option<Turn>) {
        self.turn = turn;
        match &self.turn {
            Some(Turn { after: After::Nobody, .. }) => self.take_turn(),
            Some(Turn { after: After::Blocks(blocks), .. }) if blocks.is_due() => self.take_turn(),
            _ => {}
        }
    }

    /// Processes a reply of another servo: afterwards it may be this servo's turn.
    pub(super) fn hear_status(&mut self, id: u8) {
        if matches!(self.turn, Some(Turn { after: After::Servo(before), .. }) if before == id) {
            self.take_turn();
        }
    }

    /// Counts the bytes that the servos before this one send in a fast reply.
    pub(super) fn hear_turn(&mut self, bytes: &[u8]) {
        let Some(Turn { after: After::Blocks(blocks), .. }) = &mut self.turn else { return };
        for byte in bytes {
            blocks.hear(*byte);
        }
        if blocks.is_due() {
            self.take_turn();
        }
    }

    /// Takes the turn when the servo before it stays silent.
    pub(super) fn miss_turn(&mut self) {
        if matches!(self.turn, Some(Turn { after: After::Servo(_), .. })) {
            self.take_turn();
        }
    }

    fn take_turn(&mut self) {
        let Some(turn) = self.turn.take() else { return };
        let After::Blocks(blocks) = turn.after else {
            return self.answer_read(turn.address, turn.length, self.return_delay_us());
        };
        if self.memory.get(address::STATUS_LEVEL) < 1 {
            return;
        }
        let mut data = [0; READ_LEN];
        let Some(data) = data.get_mut(..usize::from(turn.length)) else { return };
        let read = self.memory.read(turn.address, data);
        let status = Status { id: self.id(), error: self.error(read.err()), data };
        // Only the first servo waits for its return delay; the others follow at once.
        let delay_us = if blocks.is_first() { self.return_delay_us() } else { 0 };
        self.encode(delay_us, |out| blocks.encode(&status, out));
    }
}
