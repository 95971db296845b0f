//! A bus line: its protocol, its rate, and its traffic.

use std::collections::HashMap;

use sinew_rig::servo::Address;
use sinew_servo_bus::feetech::table::BAUDS as FEETECH_BAUDS;
use sinew_servo_bus::{Timing, dynamixel, feetech};
use sinew_servo_sim::registers::RegisterTable;
use sinew_servo_sim::rig::RigServo;

use super::error::PartsError;
use super::options::Options;
use super::pulses::{self, I2C_HZ};
use super::schedule::Load;
use super::servo_part::{Drive, ServoPart, table};

/// Default rate of Dynamixel lines, bit/s: all models except the oldest support it.
const DYNAMIXEL_BAUD: u32 = 4_000_000;
/// Default rate of Dynamixel lines on a board, bit/s: an exact divisor of the 90 MHz of an STM32F446's UART. 4 Mbit/s
/// would be 2 % off.
const BOARD_BAUD: u32 = 3_000_000;
/// Rate of Feetech servos, bit/s: their factory setting and their highest rate.
const FEETECH_BAUD: u32 = 1_000_000;

/// A bus line with servos.
#[derive(Debug, Clone)]
pub struct Line {
    /// Name of the bus.
    pub name: String,
    /// Rate, bit/s.
    pub baud: u32,
    /// Indices of the line's servos in the rig.
    pub servos: Vec<usize>,
    pub(super) spoken: Spoken,
}

/// The protocol of a line.
#[derive(Debug, Clone, Copy)]
pub(super) enum Spoken {
    /// Access to registers, in a maker's protocol.
    Registers(RegisterTable),
    /// I2C writes to a PCA9685, which makes pulses.
    Pulses,
}

impl Line {
    /// Returns whether the line has Dynamixel servos.
    pub fn is_dynamixel(&self) -> bool {
        matches!(self.spoken, Spoken::Registers(RegisterTable::Dynamixel(_)))
    }

    /// Returns whether the line's servos are driven by pulses and report nothing.
    pub fn is_of_pulses(&self) -> bool {
        matches!(self.spoken, Spoken::Pulses)
    }

    /// Returns the traffic of the line in a tick.
    pub(super) fn load(&self, servos: &[ServoPart]) -> Load {
        let table = match self.spoken {
            Spoken::Registers(table) => table,
            Spoken::Pulses => {
                let own: Vec<&ServoPart> = self.servos.iter().map(|at| &servos[*at]).collect();
                let traffic = pulses::traffic(&own);
                // Torque is switched by the same write.
                return Load {
                    timing: pulses::TIMING,
                    traffic,
                    switch_bytes: 0,
                    closes_loop: false,
                };
            }
        };
        let count = |number: usize| u32::try_from(number).unwrap_or(u32::MAX);
        let driven = |drive| self.servos.iter().filter(|s| servos[**s].drive == drive).count();
        let [currents, voltages, positions] =
            [Drive::Current, Drive::Voltage, Drive::Position].map(driven).map(count);
        let all = currents + voltages + positions;
        let (traffic, switch_bytes) = match table {
            RegisterTable::Dynamixel(_) => {
                let mut traffic = dynamixel::traffic(all, 2, true);
                // A packet of currents, a packet of voltages, and a packet of positions with their speeds.
                let of =
                    |servos: u32, len: u32| if servos == 0 { 0 } else { 14 + servos * (1 + len) };
                traffic.write.fixed = of(currents, 2) + of(voltages, 2) + of(positions, 8);
                traffic.write.each = 0;
                (traffic, 14 + 2 * all)
            }
            RegisterTable::Feetech(table) => {
                (feetech::traffic(table.model.family, all).with_goal(6), 14 + 2 * all)
            }
        };
        let timing = Timing { baud: self.baud, return_delay_us: 2, turnaround_us: 5 };
        Load { timing, traffic, switch_bytes, closes_loop: currents + voltages > 0 }
    }
}

/// Creates the lines of a rig, without servos; these are added later.
pub(super) fn lines(servos: &[RigServo], options: Options) -> Result<Vec<Line>, PartsError> {
    let mut lines: Vec<Line> = Vec::new();
    let mut first: HashMap<&str, &RigServo> = HashMap::new();
    for servo in servos {
        let spoken = spoken(servo)?;
        let one = *first.entry(&servo.bus).or_insert(servo);
        let Some(line) = lines.iter().find(|line| line.name == servo.bus) else {
            let (known, usual): (&[u32], u32) = match spoken {
                Spoken::Registers(RegisterTable::Dynamixel(_)) if options.is_of_board => {
                    (&dynamixel::table::BAUDS, BOARD_BAUD)
                }
                Spoken::Registers(RegisterTable::Dynamixel(_)) => {
                    (&dynamixel::table::BAUDS, DYNAMIXEL_BAUD)
                }
                Spoken::Registers(RegisterTable::Feetech(_)) => (&FEETECH_BAUDS, FEETECH_BAUD),
                Spoken::Pulses => (&[I2C_HZ], I2C_HZ),
            };
            // The option applies to serial lines only.
            let asked = options.baud.filter(|_| !matches!(spoken, Spoken::Pulses));
            let baud = asked.unwrap_or(usual);
            let bus = servo.bus.clone();
            if !known.contains(&baud) {
                let known = known.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
                return Err(PartsError::Baud { baud, bus, known });
            }
            lines.push(Line { name: bus, baud, servos: Vec::new(), spoken });
            continue;
        };
        if !spoken.is_same(line.spoken) {
            let (one, other) = (one.name.clone(), servo.name.clone());
            return Err(PartsError::TwoProtocols { bus: line.name.clone(), one, other });
        }
    }
    Ok(lines)
}

/// Returns the protocol of a servo.
fn spoken(servo: &RigServo) -> Result<Spoken, PartsError> {
    match (table(servo), servo.address) {
        (Some(table), Address::Id(_)) => Ok(Spoken::Registers(table)),
        (None, Address::Channel(_)) => Ok(Spoken::Pulses),
        (Some(_), Address::Channel(channel)) => Err(PartsError::Address {
            servo: servo.name.clone(),
            model: servo.kind.name.clone(),
            expected: "an `id`, since it is on a bus",
            found: format!("channel {channel}"),
        }),
        (None, Address::Id(id)) => Err(PartsError::Address {
            servo: servo.name.clone(),
            model: servo.kind.name.clone(),
            expected: "a `channel`, if it is driven by pulses; its registers are not known",
            found: format!("id {id}"),
        }),
    }
}

impl Spoken {
    fn is_same(self, other: Self) -> bool {
        match (self, other) {
            (
                Self::Registers(RegisterTable::Dynamixel(_)),
                Self::Registers(RegisterTable::Dynamixel(_)),
            )
            | (Self::Pulses, Self::Pulses) => true,
            (
                Self::Registers(RegisterTable::Feetech(a)),
                Self::Registers(RegisterTable::Feetech(b)),
            ) => a.model.family == b.model.family,
            _ => false,
        }
    }
}
