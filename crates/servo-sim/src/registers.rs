//! Servos without physics: registers that follow the protocol, and a position that jumps to the goal.
//!
//! They are for kinds that are not identified, and for programs that test their protocol and not the mechanics.

use sinew_servo_bus::dynamixel::table::{BAUDS as DYNAMIXEL_BAUDS, MODELS, Model, Table, address};
use sinew_servo_bus::feetech::table::{
    BAUDS as FEETECH_BAUDS, MODELS as FEETECH_MODELS, Model as FeetechModel,
    address as feetech_address,
};
use sinew_servo_bus::{BusDevice, dynamixel, feetech};

use crate::device::codes::code_of;
use crate::device::error::ServoError;
use crate::device::limits::{LONGEST, MEMORY_LEN, check_memory};
use crate::fault::Fault;
use crate::line::LineDevice;
use crate::wire::{self, Listener};

/// Feetech addresses of voltage and temperature.
const PRESENT_VOLTAGE: u8 = 62;
const PRESENT_TEMPERATURE: u8 = 63;
/// Constant measurements that the servo reports: 5 V or 7.4 V, in 0.1 V, and a case temperature after an hour in a
/// room, °C.
const DYNAMIXEL_SENSORS: [(u16, i32); 2] =
    [(address::PRESENT_VOLTAGE, 50), (address::PRESENT_TEMPERATURE, 31)];
const FEETECH_SENSORS: [(u8, i32); 2] = [(PRESENT_VOLTAGE, 74), (PRESENT_TEMPERATURE, 31)];

/// The register table of a servo.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegisterTable {
    /// Table of a Dynamixel.
    Dynamixel(Table),
    /// Table of a Feetech.
    Feetech(feetech::Table),
}

/// Firmware version, which decides the addresses of indirect data in small servos.
const FIRMWARE: u8 = 52;

impl RegisterTable {
    /// Looks up a table by the maker's name of a kind, with or without the suffix for a plug (`-T`) or a voltage
    /// (`-12V`). Returns `None` if the kind has no table.
    pub fn of(kind: &str) -> Option<Self> {
        let dynamixel =
            Model::of_kind(kind).map(|model| Self::Dynamixel(Table { model, firmware: FIRMWARE }));
        let feetech = || FeetechModel::of_kind(kind);
        dynamixel.or_else(|| feetech().map(|model| Self::Feetech(feetech::Table::new(model))))
    }

    /// Returns the names of all kinds with a table.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let feetech = FEETECH_MODELS.iter().map(|model| model.name);
        MODELS.iter().map(|model| model.name).chain(feetech)
    }

    /// Returns the maker's name of the servo.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Dynamixel(table) => table.model.name,
            Self::Feetech(table) => table.model.name,
        }
    }
}

/// The registers of one servo.
pub struct RegisterServo<'m>(Device<'m>);

enum Device<'m> {
    Dynamixel(Box<dynamixel::Device<'m, LONGEST>>),
    Feetech(Box<feetech::Device<'m>>),
}

impl<'m> RegisterServo<'m> {
    /// Creates a servo with factory settings except its baud rate, at the middle of its range. `memory` needs
    /// [`MEMORY_LEN`] bytes.
    ///
    /// # Errors
    /// [`ServoError`] if `memory` is too small, or the protocol has no code for the rate.
    pub fn new(
        table: RegisterTable,
        id: u8,
        baud: u32,
        memory: &'m mut [u8],
    ) -> Result<Self, ServoError> {
        check_memory(memory, MEMORY_LEN)?;
        let mut servo = match table {
            RegisterTable::Dynamixel(table) => {
                let mut device = Box::new(dynamixel::Device::new(table, id, memory));
                let registers = device.memory_mut();
                registers.set(address::BAUD, code_of(baud, &DYNAMIXEL_BAUDS)?);
                registers.set(address::GOAL_POSITION, 2048);
                for (at, value) in DYNAMIXEL_SENSORS {
                    registers.set(at, value);
                }
                Self(Device::Dynamixel(device))
            }
            RegisterTable::Feetech(table) => {
                let mut device = Box::new(feetech::Device::new(table, id, memory));
                let middle = (table.model.family.most_count() + 1) / 2;
                device.set(feetech_address::BAUD, code_of(baud, &FEETECH_BAUDS)?);
                device.set(feetech_address::GOAL_POSITION, middle);
                for (at, value) in FEETECH_SENSORS {
                    device.set(at, value);
                }
                Self(Device::Feetech(device))
            }
        };
        servo.go();
        Ok(servo)
    }

    /// Sets the position to the goal.
    fn go(&mut self) {
        match &mut self.0 {
            Device::Dynamixel(device) => {
                let registers = device.memory_mut();
                registers.set(address::PRESENT_POSITION, registers.get(address::GOAL_POSITION));
            }
            Device::Feetech(device) => {
                let goal = device.get(feetech_address::GOAL_POSITION);
                device.set(feetech_address::PRESENT_POSITION, goal);
            }
        }
    }
}

impl BusDevice for RegisterServo<'_> {
    fn hear(&mut self, bytes: &[u8]) {
        match &mut self.0 {
            Device::Dynamixel(device) => device.hear(bytes),
            Device::Feetech(device) => device.hear(bytes),
        }
        self.go();
    }

    fn due_us(&self) -> Option<u32> {
        match &self.0 {
            Device::Dynamixel(device) => device.due_us(),
            Device::Feetech(device) => device.due_us(),
        }
    }

    fn speak(&mut self, out: &mut [u8]) -> usize {
        match &mut self.0 {
            Device::Dynamixel(device) => device.speak(out),
            Device::Feetech(device) => device.speak(out),
        }
    }

    fn silence(&mut self) {
        match &mut self.0 {
            Device::Dynamixel(device) => device.silence(),
            Device::Feetech(device) => device.silence(),
        }
    }
}

impl Listener for RegisterServo<'_> {
    fn rate(&self) -> u32 {
        match &self.0 {
            Device::Dynamixel(device) => device.baud(),
            Device::Feetech(device) => device.baud(),
        }
    }
}

/// Several register servos on one wire. Only faults of replies affect them.
pub struct Registers<'m> {
    servos: Vec<RegisterServo<'m>>,
    /// Faults of the servos, with their times.
    pub faults: Vec<Fault>,
    /// Baud rate of the master, bits per second.
    pub baud: u32,
    now_ns: u64,
}

impl<'m> Registers<'m> {
    /// Creates servos at time 0. The master starts at the baud rate of the first servo.
    pub fn new(servos: Vec<RegisterServo<'m>>) -> Self {
        let baud = servos.first().map_or(1_000_000, Listener::rate);
        Self { servos, faults: Vec::new(), baud, now_ns: 0 }
    }
}

impl LineDevice for Registers<'_> {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// Advances the time. Watchdogs are not simulated, because there is no motion to stop.
    fn run_until(&mut self, ns: u64) {
        self.now_ns = self.now_ns.max(ns);
    }

    fn wire_ns(&self, bytes: usize) -> u64 {
        wire::took_ns(bytes, self.baud)
    }

    fn set_rate(&mut self, baud: u32) {
        self.baud = baud;
    }

    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        wire::hear(&mut self.servos, self.baud, bytes, speaker);
    }

    fn next_speaker(&self) -> Option<(usize, u32)> {
        wire::next_speaker(&self.servos)
    }

    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)> {
        let time_s = self.now_ns as f64 * 1e-9;
        wire::speak(self.servos.get_mut(speaker)?, speaker, &self.faults, time_s)
    }

    fn silence(&mut self) {
        self.servos.iter_mut().for_each(BusDevice::silence);
    }
}
