//! A servo's side of the protocol, over a memory image that the caller owns.
//!
//! What moves is not here: a simulation writes what sensors see into [`Device::memory`], and reads goals out of it.

mod event;
mod memory;
mod reads;
mod servo;
mod turn;

use heapless::{Deque, Vec};

use super::frame::{MAX_ID, STATUS};
use super::parser::Parser;
use super::status::ErrorCode;
use super::table::{BAUDS, Table, address};
use crate::line::BusDevice;
pub use event::Event;
pub use memory::Memory;
use servo::{Answers, Servo};

/// A servo on a line. `N` is the longest packet that it takes or gives.
///
/// What real servos were not observed to do follows the text of the protocol:
/// - in a sync or bulk read it answers when the servo before it has; if that stays silent, it answers after a silence;
/// - in a fast one it never answers without those before it: the CRC needs their bytes;
/// - all answer a broadcast ping in the order of their ids.
pub struct Device<'m, const N: usize> {
    parser: Parser<N>,
    servo: Servo<'m, N>,
}

impl<'m, const N: usize> Device<'m, N> {
    /// A servo that was just switched on, with what the factory sets and this id. `memory` needs [`Table::size`] bytes;
    /// what it lacks reads as 0.
    pub fn new(table: Table, id: u8, memory: &'m mut [u8]) -> Self {
        let mut memory = Memory::new(table, memory);
        memory.reset_all();
        memory.set(address::ID, id.min(MAX_ID).into());
        let servo = Servo {
            memory,
            turn: None,
            registered: Vec::new(),
            answer: Vec::new(),
            due_us: None,
            silent_us: 0,
            events: Deque::new(),
        };
        Self { parser: Parser::new(), servo }
    }

    /// Its control table.
    pub fn memory(&self) -> &Memory<'m> {
        &self.servo.memory
    }

    /// Its control table, for what its sensors see.
    pub fn memory_mut(&mut self) -> &mut Memory<'m> {
        &mut self.servo.memory
    }

    /// At what rate it listens, bits per second.
    pub fn baud(&self) -> u32 {
        let code = self.servo.memory.get(address::BAUD);
        usize::try_from(code).ok().and_then(|code| BAUDS.get(code)).copied().unwrap_or(57_600)
    }

    /// What happened, oldest first.
    pub fn next_event(&mut self) -> Option<Event> {
        self.servo.events.pop_front()
    }

    /// Time passes. The bus watchdog counts while torque is on.
    pub fn pass_time(&mut self, dt_us: u32) {
        let servo = &mut self.servo;
        servo.silent_us = servo.silent_us.saturating_add(dt_us);
        let limit = servo.memory.get(address::BUS_WATCHDOG);
        let limit_us = u32::try_from(limit).unwrap_or(0).saturating_mul(20_000);
        if limit > 0 && servo.memory.torque_is_on() && servo.silent_us > limit_us {
            servo.memory.set(address::BUS_WATCHDOG, -1);
            servo.note(Event::WatchdogRanOut);
        }
    }
}

impl<const N: usize> BusDevice for Device<'_, N> {
    fn hear(&mut self, bytes: &[u8]) {
        self.servo.hear_turn(bytes);
        let mut input = bytes;
        while let Some(packet) = self.parser.next(&mut input) {
            self.servo.take(&packet);
            // What came whole behind damage is answered, not the damage.
            self.parser.take_damaged();
        }
        let damaged = self.parser.take_damaged();
        if damaged.is_some_and(|(id, instruction)| id == self.servo.id() && instruction != STATUS) {
            self.servo.reply(Answers::All, Err(ErrorCode::Crc));
        }
    }

    fn due_us(&self) -> Option<u32> {
        self.servo.due_us
    }

    fn speak(&mut self, out: &mut [u8]) -> usize {
        self.servo.due_us = None;
        // What it had begun to hear ends with its own words.
        self.parser.clear();
        let len = self.servo.answer.len().min(out.len());
        for (to, from) in out.iter_mut().zip(&self.servo.answer) {
            *to = *from;
        }
        len
    }

    fn silence(&mut self) {
        while let Some(packet) = self.parser.flush() {
            self.servo.take(&packet);
        }
        self.parser.take_damaged();
        self.servo.miss_turn();
    }
}
