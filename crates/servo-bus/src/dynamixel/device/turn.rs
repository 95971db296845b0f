//! The turn of a servo in a read of several servos.

use crate::dynamixel::fast::FastTurn;
use crate::dynamixel::group::{BulkEntry, bulk_entries};
use crate::dynamixel::instruction::Span;

/// A read that the servo must answer after another servo.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) address: u16,
    pub(super) length: u16,
    pub(super) after: After,
}

/// The answer that a servo waits for before it sends its own.
#[derive(Debug, Clone)]
pub(super) enum After {
    /// No answer: the servo answers at once.
    Nobody,
    /// The reply of this servo.
    Servo(u8),
    /// The parts of the other servos in a fast reply, which is one packet for all.
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
