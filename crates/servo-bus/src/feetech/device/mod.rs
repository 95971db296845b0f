//! A servo's side of the protocol, over a memory image that the caller owns.

mod execute;

use heapless::{Deque, Vec};

use super::parser::Parser;
use super::table::{BAUDS, Table, address};
use crate::line::BusDevice;

/// What happened to a device that its simulation may want to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Items were written.
    Written {
        /// First address.
        address: u8,
        /// How many bytes.
        length: u8,
    },
    /// It starts anew: silent for about 0.8 s, torque off, EEPROM as it was stored.
    Rebooted,
    /// It is as it left the factory, but for its id.
    FactoryReset,
    /// It forgot full turns.
    TurnsCleared,
    /// Where it stands is now this position.
    PositionSet(i32),
}

const EEPROM_LEN: usize = address::TORQUE_ENABLE as usize;
/// The longest packet of the protocol.
const LONGEST: usize = 259;
/// A servo on a line.
///
/// What the manuals leave open follows what was measured on an STS3215 (feetech-cli 0.1.8, `simulator.py`): a write
/// of the goal position switches torque on, and a write that the servo does not take is not reported. What is written
/// to EEPROM while the lock is shut holds until a reboot. The manuals say that Return Delay does nothing on STS, so
/// it does not here.
pub struct Device<'m> {
    table: Table,
    memory: &'m mut [u8],
    /// What survives a loss of power.
    stored: [u8; EEPROM_LEN],
    parser: Parser<LONGEST>,
    /// A read of several servos that it answers after another one.
    turn: Option<Turn>,
    registered: Vec<u8, LONGEST>,
    answer: Vec<u8, LONGEST>,
    due_us: Option<u32>,
    events: Deque<Event, 8>,
}

#[derive(Debug, Clone, Copy)]
struct Turn {
    after: u8,
    address: u8,
    length: u8,
}

impl<'m> Device<'m> {
    /// A servo that was just switched on, with what the factory sets and this id. `memory` needs 256 bytes; what it
    /// lacks reads as 0.
    pub fn new(table: Table, id: u8, memory: &'m mut [u8]) -> Self {
        let mut device = Self {
            table,
            memory,
            stored: [0; EEPROM_LEN],
            parser: Parser::new(),
            turn: None,
            registered: Vec::new(),
            answer: Vec::new(),
            due_us: None,
            events: Deque::new(),
        };
        device.reset_all(id);
        device
    }

    /// The number that an item holds; 0 if the servo has no item there.
    pub fn get(&self, address: u8) -> i32 {
        let Some(item) = self.table.at(address) else { return 0 };
        let bytes =
            self.memory.get(usize::from(item.address)..usize::from(item.end())).unwrap_or_default();
        item.value(bytes, self.table.model.family.order())
    }

    /// Sets an item, without asking whether a controller could.
    pub fn set(&mut self, address: u8, value: i32) {
        let Some(item) = self.table.at(address) else { return };
        let bytes = item.bytes(value, self.table.model.family.order());
        for (to, byte) in (usize::from(item.address)..).zip(bytes.iter().take(item.size.into())) {
            self.put(to, *byte, true);
        }
    }

    /// At what rate it listens, bits per second.
    pub fn baud(&self) -> u32 {
        let code = usize::try_from(self.get(address::BAUD)).ok();
        code.and_then(|code| BAUDS.get(code)).copied().unwrap_or(1_000_000)
    }

    /// What happened, oldest first.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Its table.
    pub fn table(&self) -> Table {
        self.table
    }
}

impl BusDevice for Device<'_> {
    fn hear(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        // The parser lends its bytes to the packet, and the packet goes to the rest of the device.
        let mut parser = core::mem::take(&mut self.parser);
        while let Some(packet) = parser.next(&mut input) {
            self.take(&packet);
        }
        self.parser = parser;
    }

    fn due_us(&self) -> Option<u32> {
        self.due_us
    }

    fn speak(&mut self, out: &mut [u8]) -> usize {
        self.due_us = None;
        let len = self.answer.len().min(out.len());
        for (to, from) in out.iter_mut().zip(&self.answer) {
            *to = *from;
        }
        len
    }

    fn silence(&mut self) {
        let mut parser = core::mem::take(&mut self.parser);
        while let Some(packet) = parser.flush() {
            self.take(&packet);
        }
        self.parser = parser;
        if let Some(turn) = self.turn.take() {
            self.answer_read(turn.address, turn.length);
        }
    }
}
