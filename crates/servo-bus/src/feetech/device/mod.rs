//! A simulated servo's side of the protocol, over a memory image that the caller owns.

mod execute;

use heapless::{Deque, Vec};

use super::parser::Parser;
use super::table::{BAUDS, Table, address};
use crate::line::BusDevice;
use crate::table::Restriction;

/// An event that the simulation of a servo may want to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A controller wrote registers.
    Written {
        /// First address that was written.
        address: u8,
        /// Number of bytes that were written.
        length: u8,
    },
    /// The servo restarted: it is silent for about 0.8 s, torque is off, and EEPROM holds the stored values.
    Rebooted,
    /// The servo returned to its factory settings, except its id.
    FactoryReset,
    /// The servo cleared its full turns.
    TurnsCleared,
    /// The servo now counts its present angle as this position, in counts.
    PositionSet(i32),
}

const EEPROM_LEN: usize = address::TORQUE_ENABLE as usize;
/// The longest packet of the protocol.
const LONGEST: usize = 259;
/// A simulated servo on a bus line.
///
/// Behaviour that the manuals do not describe follows measurements on an STS3215 (feetech-cli 0.1.8, `simulator.py`): a
/// write of the goal position switches torque on, and a refused write is not reported. A value written to EEPROM while
/// the lock is shut is valid until a reboot. The manuals say that Return Delay has no effect on STS, so this device
/// ignores it.
pub struct Device<'m> {
    table: Table,
    memory: &'m mut [u8],
    /// EEPROM contents that survive a loss of power.
    stored: [u8; EEPROM_LEN],
    parser: Parser<LONGEST>,
    /// A read of several servos that this servo answers after another servo.
    turn: Option<Turn>,
    registered: Vec<u8, LONGEST>,
    answer: Vec<u8, LONGEST>,
    due_us: Option<u32>,
    events: Deque<Event, 8>,
    restrictions: &'static [Restriction],
}

#[derive(Debug, Clone, Copy)]
struct Turn {
    after: u8,
    address: u8,
    length: u8,
}

impl<'m> Device<'m> {
    /// Creates a servo that was just switched on, with factory settings and this id. `memory` needs 256 bytes; missing
    /// bytes read as 0.
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
            restrictions: &[],
        };
        device.reset_all(id);
        device
    }

    /// Sets which values a controller cannot write: a register then keeps its value, and no answer says so.
    pub fn restrict(&mut self, restrictions: &'static [Restriction]) {
        self.restrictions = restrictions;
    }

    /// Returns the value of a register, or 0 if the servo has no register at `address`.
    pub fn get(&self, address: u8) -> i32 {
        let Some(item) = self.table.at(address) else { return 0 };
        let bytes =
            self.memory.get(usize::from(item.address)..usize::from(item.end())).unwrap_or_default();
        item.value(bytes, self.table.model.family.order())
    }

    /// Sets a register, even if a controller could not write it.
    pub fn set(&mut self, address: u8, value: i32) {
        let Some(item) = self.table.at(address) else { return };
        let bytes = item.bytes(value, self.table.model.family.order());
        for (to, byte) in (usize::from(item.address)..).zip(bytes.iter().take(item.size.into())) {
            self.put(to, *byte, true);
        }
    }

    /// Returns the current baud rate, bits per second; 1,000,000 if its register has an unknown code.
    pub fn baud(&self) -> u32 {
        let code = usize::try_from(self.get(address::BAUD)).ok();
        code.and_then(|code| BAUDS.get(code)).copied().unwrap_or(1_000_000)
    }

    /// Returns the oldest event that was not yet returned, or `None` if there is none.
    pub fn next_event(&mut self) -> Option<Event> {
        self.events.pop_front()
    }

    /// Returns the memory table of the servo's model.
    pub fn table(&self) -> Table {
        self.table
    }
}

impl BusDevice for Device<'_> {
    fn hear(&mut self, bytes: &[u8]) {
        let mut input = bytes;
        // The parser lends its bytes to the packet while the rest of the device processes it: the parser is therefore
        // moved out meanwhile.
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
