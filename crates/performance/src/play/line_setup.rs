//! The setup of a line's bus.

use sinew_servo_bus::pca9685::{self, ChannelSetup};
use sinew_servo_bus::{Schedule, ServoBus, dynamixel, feetech};
use sinew_servo_sim::registers::RegisterTable;
use sinew_wiring::{LineServo, Protocol};

use super::SERVOS;
use super::error::PartsError;
use super::line::{Line, Spoken};
use super::pulses;
use super::rig_parts::RigParts;
use super::servo_part::{current_a, encoder, mode, no_load_rad_s, single, table as table_of};

/// Factor on the servo's no-load speed. A reading that implies a higher speed is not accepted at once.
const SPEED_ROOM: f64 = 2.0;

impl RigParts {
    /// Makes the bus of each line, with the drive of each of its servos.
    pub(super) fn buses(&self) -> Result<Vec<Box<dyn ServoBus>>, PartsError> {
        let each = self.lines.iter().zip(&self.schedules);
        each.map(|(line, schedule)| self.bus(line, *schedule)).collect()
    }

    fn bus(&self, line: &Line, schedule: Schedule) -> Result<Box<dyn ServoBus>, PartsError> {
        let failed = |reason| PartsError::Bus { bus: line.name.clone(), reason };
        Ok(match self.line_setup(line) {
            LineSetup::Dynamixel(setups, settings) => {
                let bus = dynamixel::Bus::<SERVOS>::new(&setups, schedule, settings);
                Box::new(bus.map_err(failed)?)
            }
            LineSetup::Feetech(setups, settings) => {
                let bus = feetech::Bus::<SERVOS>::new(&setups, schedule, settings);
                Box::new(bus.map_err(failed)?)
            }
            LineSetup::Pulses(setups) => {
                let bus = pca9685::Bus::new(&setups, pulses::prescale(), line.baud);
                Box::new(bus.map_err(failed)?)
            }
        })
    }

    /// Returns the setup of a line's bus.
    pub(super) fn line_setup(&self, line: &Line) -> LineSetup {
        let table = match line.spoken {
            Spoken::Registers(table) => table,
            Spoken::Pulses => {
                let setup = |index: &usize| {
                    let own = self.board.servos()[*index].servo.settings();
                    pulses::setup(&self.servos[*index], own.range_rad)
                };
                return LineSetup::Pulses(line.servos.iter().map(setup).collect());
            }
        };
        let of = |index: &usize| {
            let (part, setup) = (&self.servos[*index], &self.setups[*index]);
            let encoder = encoder(part);
            // The last step of the turn is the first of the next.
            let last_rad = encoder.turn_rad - single(part.own.kind.resolution_rad);
            let own = self.board.servos()[*index].servo.settings();
            let range_rad = own.range_rad.map(|end| (end + encoder.zero_rad).clamp(0.0, last_rad));
            let speed_rad_s = single(SPEED_ROOM * no_load_rad_s(&part.own));
            (part, setup, range_rad, speed_rad_s)
        };
        match table {
            RegisterTable::Dynamixel(_) => {
                let mut setups = Vec::new();
                for index in &line.servos {
                    let (part, setup, range_rad, speed_rad_s) = of(index);
                    let Some(RegisterTable::Dynamixel(table)) = table_of(&part.own) else {
                        continue;
                    };
                    setups.push(dynamixel::ServoSetup {
                        id: part.own.id().unwrap_or_default(),
                        model: table.model,
                        mode: mode(part.drive),
                        range_rad,
                        current_a: current_a(setup.stall_a),
                        pwm: 1.0,
                        speed_rad_s,
                    });
                }
                LineSetup::Dynamixel(setups, dynamixel::Settings { fast: true, retries: 1 })
            }
            RegisterTable::Feetech(table) => {
                let setup = |index: &usize| {
                    let (part, _, range_rad, speed_rad_s) = of(index);
                    let id = part.own.id().unwrap_or_default();
                    let mode = feetech::Mode::Position;
                    feetech::ServoSetup { id, mode, range_rad, pwm: 1.0, speed_rad_s }
                };
                let setups = line.servos.iter().map(setup).collect();
                let family = table.model.family;
                let settings =
                    feetech::Settings { family, echo: false, retries: 1, speed_counts: 1 };
                LineSetup::Feetech(setups, settings)
            }
        }
    }
}

/// The servos of a line, and the settings of its protocol.
pub(super) enum LineSetup {
    Dynamixel(Vec<dynamixel::ServoSetup>, dynamixel::Settings),
    Feetech(Vec<feetech::ServoSetup>, feetech::Settings),
    Pulses(Vec<ChannelSetup>),
}

impl LineSetup {
    /// Returns the protocol of the line.
    pub(super) fn protocol(&self) -> Protocol {
        match self {
            Self::Dynamixel(_, settings) => Protocol::Dynamixel(*settings),
            Self::Feetech(_, settings) => Protocol::Feetech(*settings),
            Self::Pulses(_) => Protocol::Pca9685(pulses::PULSES),
        }
    }

    /// Returns a servo of the line by its place; `None` beyond the last servo.
    pub(super) fn servo(&self, place: usize) -> Option<LineServo> {
        Some(match self {
            Self::Dynamixel(setups, _) => LineServo::Dynamixel((*setups.get(place)?).into()),
            Self::Feetech(setups, _) => LineServo::Feetech(*setups.get(place)?),
            Self::Pulses(setups) => LineServo::Channel(*setups.get(place)?),
        })
    }
}
