//! When a servo answers a read of several.

use super::servo::{READ_LEN, Servo};
use crate::dynamixel::fast::FastTurn;
use crate::dynamixel::group::{BulkEntry, bulk_entries};
use crate::dynamixel::instruction::Span;
use crate::dynamixel::status::Status;
use crate::dynamixel::table::address;

/// What a servo has to answer, and after whom.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    address: u16,
    length: u16,
    after: After,
}

#[derive(Debug, Clone)]
enum After {
    /// At once.
    Nobody,
    /// After this servo's reply.
    Servo(u8),
    /// In one packet with the others.
    Blocks(FastTurn),
}

impl Turn {
    pub(super) fn of_sync(span: &Span<'_>, own: u8, is_fast: bool) -> Option<Self> {
        let entries =
            span.ids.iter().map(|&id| BulkEntry { id, address: span.address, length: span.length });
        Self::new(entries, own, is_fast)
    }

    pub(super) fn of_bulk(list: &[u8], own: u8, is_fast: bool) -> Option<Self> {
        Self::new(bulk_entries(list), own, is_fast)
    }

    fn new(
        entries: impl Iterator<Item = BulkEntry> + Clone,
        own: u8,
        is_fast: bool,
    ) -> Option<Self> {
        let position = entries.clone().position(|entry| entry.id == own)?;
        let entry = entries.clone().nth(position)?;
        let after = if is_fast {
            let lengths = entries.map(|entry| entry.length);
            After::Blocks(FastTurn::new(lengths.clone().take(position), lengths))
        } else {
            let before = position.checked_sub(1).and_then(|before| entries.clone().nth(before));
            before.map_or(After::Nobody, |before| After::Servo(before.id))
        };
        Some(Self { address: entry.address, length: entry.length, after })
    }
}

impl<const N: usize> Servo<'_, N> {
    pub(super) fn await_turn(&mut self, turn: Option<Turn>) {
        self.turn = turn;
        match &self.turn {
            Some(Turn { after: After::Nobody, .. }) => self.take_turn(),
            Some(Turn { after: After::Blocks(blocks), .. }) if blocks.is_due() => self.take_turn(),
            _ => {}
        }
    }

    /// Another servo has replied.
    pub(super) fn hear_status(&mut self, id: u8) {
        if matches!(self.turn, Some(Turn { after: After::Servo(before), .. }) if before == id) {
            self.take_turn();
        }
    }

    /// Listens for the parts of servos before it.
    pub(super) fn hear_turn(&mut self, bytes: &[u8]) {
        let Some(Turn { after: After::Blocks(blocks), .. }) = &mut self.turn else { return };
        for byte in bytes {
            blocks.hear(*byte);
        }
        if blocks.is_due() {
            self.take_turn();
        }
    }

    /// The servo before it stays silent.
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
        // Only the first one waits; the others follow at once.
        let delay_us = if blocks.is_first() { self.return_delay_us() } else { 0 };
        self.encode(delay_us, |out| blocks.encode(&status, out));
    }
}
