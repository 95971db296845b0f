//! Servos without physics: registers with the right manners, each at once where it was sent.
//!
//! For kinds that nobody has identified, and for programs that want to know what they write and not what metal makes of
//! it.

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

/// Feetech: voltage, temperature.
const PRESENT_VOLTAGE: u8 = 62;
const PRESENT_TEMPERATURE: u8 = 63;
/// What it says of itself: 5 V or 7.4 V, 0.1 V, and a room's air after an hour, °C.
const DYNAMIXEL_SENSORS: [(u16, i32); 2] =
    [(address::PRESENT_VOLTAGE, 50), (address::PRESENT_TEMPERATURE, 31)];
const FEETECH_SENSORS: [(u8, i32); 2] = [(PRESENT_VOLTAGE, 74), (PRESENT_TEMPERATURE, 31)];

/// Whose registers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RegisterTable {
    /// A Dynamixel's.
    Dynamixel(Table),
    /// A Feetech's.
    Feetech(feetech::Table),
}

/// Indirect data of small servos stand where this firmware has them.
const FIRMWARE: u8 = 52;

impl RegisterTable {
    /// That of a kind by the maker's name, with or without what tells plugs (`-T`) and voltages (`-12V`) apart.
    pub fn of(kind: &str) -> Option<Self> {
        let dynamixel =
            Model::of_kind(kind).map(|model| Self::Dynamixel(Table { model, firmware: FIRMWARE }));
        let feetech = || FeetechModel::of_kind(kind);
        dynamixel.or_else(|| feetech().map(|model| Self::Feetech(feetech::Table { model })))
    }

    /// Names of all kinds that have one.
    pub fn names() -> impl Iterator<Item = &'static str> {
        let feetech = FEETECH_MODELS.iter().map(|model| model.name);
        MODELS.iter().map(|model| model.name).chain(feetech)
    }

    /// The maker's name of the servo.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Dynamixel(table) => table.model.name,
            Self::Feetech(table) => table.model.name,
        }
    }
}

/// One servo's registers.
pub struct RegisterServo<'m>(Device<'m>);

enum Device<'m> {
    Dynamixel(Box<dynamixel::Device<'m, LONGEST>>),
    Feetech(Box<feetech::Device<'m>>),
}

impl<'m> RegisterServo<'m> {
    /// A servo as it left the factory, at the middle of its range, but for the rate that it listens at. `memory`:
    /// [`MEMORY_LEN`] bytes.
    ///
    /// # Errors
    /// [`ServoError`]: `memory` is too short, or its bus has no code for the rate.
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

    /// To its goal.
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

/// Such servos on one wire. Of faults they know those of replies.
pub struct Registers<'m> {
    servos: Vec<RegisterServo<'m>>,
    /// What goes wrong.
    pub faults: Vec<Fault>,
    /// At what rate the master talks, bits per second.
    pub baud: u32,
    now_ns: u64,
}

impl<'m> Registers<'m> {
    /// At time 0. The master talks as fast as the first servo listens.
    pub fn new(servos: Vec<RegisterServo<'m>>) -> Self {
        let baud = servos.first().map_or(1_000_000, Listener::rate);
        Self { servos, faults: Vec::new(), baud, now_ns: 0 }
    }
}

impl LineDevice for Registers<'_> {
    fn now_ns(&self) -> u64 {
        self.now_ns
    }

    /// No watchdog counts: what would it stop?
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
