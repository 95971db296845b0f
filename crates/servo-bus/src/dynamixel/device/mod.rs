//! A simulated servo's side of the protocol, over a memory image that the caller owns.
//!
//! Motion is not simulated in this module: a simulation writes sensor values into [`Device::memory`], and reads goals
//! from it.

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

/// A simulated servo on a bus line. `N` is the length of the longest packet that it can receive or send.
///
/// Behaviour of real servos that was not observed follows the text of the protocol:
/// - in a sync or bulk read it answers after the servo before it; if that servo stays silent, it answers after a
///   silence;
/// - in a fast read it never answers without the servos before it: the CRC needs their bytes;
/// - all answer a broadcast ping in the order of their ids.
pub struct Device<'m, const N: usize> {
    parser: Parser<N>,
    servo: Servo<'m, N>,
}

impl<'m, const N: usize> Device<'m, N> {
    /// Creates a servo that was just switched on, with factory settings and this id. `memory` needs [`Table::size`]
    /// bytes; missing bytes read as 0.
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

    /// Returns the control table.
    pub fn memory(&self) -> &Memory<'m> {
        &self.servo.memory
    }

    /// Returns the control table for writing: a simulation stores its sensor values there.
    pub fn memory_mut(&mut self) -> &mut Memory<'m> {
        &mut self.servo.memory
    }

    /// Returns the current baud rate, bits per second; 57,600 if its register has an unknown code.
    pub fn baud(&self) -> u32 {
        let code = self.servo.memory.get(address::BAUD);
        usize::try_from(code).ok().and_then(|code| BAUDS.get(code)).copied().unwrap_or(57_600)
    }

    /// Returns the oldest event that was not yet returned, or `None` if there is none.
    pub fn next_event(&mut self) -> Option<Event> {
        self.servo.events.pop_front()
    }

    /// Advances the time by `dt_us`. The bus watchdog counts while torque is on.
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
            // The servo answers a whole packet that follows damage, and does not report the damage.
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
        // A packet that it had begun to receive ends when the servo itself sends.
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
