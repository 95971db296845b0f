//! One line of servos: what talks on it, at what rate, and how much.

use std::collections::HashMap;

use sinew_rig::servo::Address;
use sinew_servo_bus::feetech::table::BAUDS as FEETECH_BAUDS;
use sinew_servo_bus::pca9685::{self, ChannelSetup};
use sinew_servo_bus::{Schedule, ServoBus, Timing, dynamixel, feetech};
use sinew_servo_sim::registers::RegisterTable;
use sinew_servo_sim::rig::RigServo;
use sinew_wiring::{LineServo, Protocol};

use super::SERVOS;
use super::parts::{Options, Parts, PartsError};
use super::pulses::{self, I2C_HZ};
use super::schedule::Load;
use super::servo_part::{Drive, ServoPart, current_a, encoder, mode, no_load_rad_s, single, table};

/// What Dynamixel lines talk at, unless told otherwise: all models but the oldest can.
const DYNAMIXEL_BAUD: u32 = 4_000_000;
/// The same on a board: what the 90 MHz of an STM32F446's UART divide to exactly. 4 Mbit/s would be 2 % off.
const BOARD_BAUD: u32 = 3_000_000;
/// What Feetech servos are shipped with, and their fastest.
const FEETECH_BAUD: u32 = 1_000_000;
/// Readings that tell more than twice the servo's own speed are not believed at once.
const SPEED_ROOM: f64 = 2.0;

/// One line of servos.
#[derive(Debug, Clone)]
pub struct Line {
    /// The name of its bus.
    pub name: String,
    /// Bits a second.
    pub baud: u32,
    /// Its servos, as the rig counts them.
    pub servos: Vec<usize>,
    spoken: Spoken,
}

/// What is spoken on a line.
#[derive(Debug, Clone, Copy)]
enum Spoken {
    /// A maker's protocol, to registers.
    Registers(RegisterTable),
    /// I2C writes to a PCA9685, which makes pulses.
    Pulses,
}

impl Line {
    /// Whether Dynamixels hang on it.
    pub fn is_dynamixel(&self) -> bool {
        matches!(self.spoken, Spoken::Registers(RegisterTable::Dynamixel(_)))
    }

    /// Whether its servos take pulses, and tell nothing.
    pub fn is_of_pulses(&self) -> bool {
        matches!(self.spoken, Spoken::Pulses)
    }

    /// What a line has to do in a tick.
    pub(super) fn load(&self, servos: &[ServoPart]) -> Load {
        let table = match self.spoken {
            Spoken::Registers(table) => table,
            Spoken::Pulses => {
                let own: Vec<&ServoPart> = self.servos.iter().map(|at| &servos[*at]).collect();
                let traffic = pulses::traffic(&own);
                // What switches torque is the same write.
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
        let [currents, positions] = [Drive::Current, Drive::Position].map(driven).map(count);
        let all = currents + positions;
        let (traffic, switch_bytes) = match table {
            RegisterTable::Dynamixel(_) => {
                let mut traffic = dynamixel::traffic(all, 2, true);
                // A packet of currents, and one of positions with their speeds.
                let of =
                    |servos: u32, len: u32| if servos == 0 { 0 } else { 14 + servos * (1 + len) };
                traffic.write.fixed = of(currents, 2) + of(positions, 8);
                traffic.write.each = 0;
                (traffic, 14 + 2 * all)
            }
            RegisterTable::Feetech(table) => {
                (feetech::traffic(table.model.family, all).with_goal(6), 14 + 2 * all)
            }
        };
        let timing = Timing { baud: self.baud, return_delay_us: 2, turnaround_us: 5 };
        Load { timing, traffic, switch_bytes, closes_loop: currents > 0 }
    }
}

/// The lines of a rig, still without servos.
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
            // What is asked for is the rate of serial lines.
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

/// What is spoken to a servo.
fn spoken(servo: &RigServo) -> Result<Spoken, PartsError> {
    match (table(servo), servo.address) {
        (Some(table), Address::Id(_)) => Ok(Spoken::Registers(table)),
        (None, Address::Channel(_)) => Ok(Spoken::Pulses),
        (Some(_), Address::Channel(channel)) => Err(PartsError::Address {
            servo: servo.name.clone(),
            model: servo.kind.name.clone(),
            expected: "an `id`, since it hangs on a bus",
            found: format!("channel {channel}"),
        }),
        (None, Address::Id(id)) => Err(PartsError::Address {
            servo: servo.name.clone(),
            model: servo.kind.name.clone(),
            expected: "a `channel`, if it takes pulses; nobody has written its registers down",
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

impl Parts {
    /// The bus of each line, with its servos as they are driven.
    pub(super) fn buses(&self) -> Result<Vec<Box<dyn ServoBus>>, PartsError> {
        let each = self.lines.iter().zip(&self.schedules);
        each.map(|(line, schedule)| self.bus(line, *schedule)).collect()
    }

    fn bus(&self, line: &Line, schedule: Schedule) -> Result<Box<dyn ServoBus>, PartsError> {
        let failed = |reason| PartsError::Bus { bus: line.name.clone(), reason };
        Ok(match self.of_line(line) {
            OfLine::Dynamixel(setups, settings) => {
                let bus = dynamixel::Bus::<SERVOS>::new(&setups, schedule, settings);
                Box::new(bus.map_err(failed)?)
            }
            OfLine::Feetech(setups, settings) => {
                let bus = feetech::Bus::<SERVOS>::new(&setups, schedule, settings);
                Box::new(bus.map_err(failed)?)
            }
            OfLine::Pulses(setups) => {
                let bus = pca9685::Bus::new(&setups, pulses::prescale(), line.baud);
                Box::new(bus.map_err(failed)?)
            }
        })
    }

    /// What a line's bus is made of.
    pub(super) fn of_line(&self, line: &Line) -> OfLine {
        let table = match line.spoken {
            Spoken::Registers(table) => table,
            Spoken::Pulses => {
                let setup = |index: &usize| {
                    let own = self.board.servos()[*index].servo.settings();
                    pulses::setup(&self.servos[*index], own.range_rad)
                };
                return OfLine::Pulses(line.servos.iter().map(setup).collect());
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
                    let Some(RegisterTable::Dynamixel(table)) = self::table(&part.own) else {
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
                OfLine::Dynamixel(setups, dynamixel::Settings { fast: true, retries: 1 })
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
                    feetech::Settings { family, echo: false, retries: 1, speed_counts: 50 };
                OfLine::Feetech(setups, settings)
            }
        }
    }
}

/// Servos of a line, and how it is read.
pub(super) enum OfLine {
    Dynamixel(Vec<dynamixel::ServoSetup>, dynamixel::Settings),
    Feetech(Vec<feetech::ServoSetup>, feetech::Settings),
    Pulses(Vec<ChannelSetup>),
}

impl OfLine {
    /// What is spoken on it.
    pub(super) fn protocol(&self) -> Protocol {
        match self {
            Self::Dynamixel(_, settings) => Protocol::Dynamixel(*settings),
            Self::Feetech(_, settings) => Protocol::Feetech(*settings),
            Self::Pulses(_) => Protocol::Pca9685(pulses::PULSES),
        }
    }

    /// What its servo at a place is there.
    pub(super) fn on_line(&self, place: usize) -> Option<LineServo> {
        Some(match self {
            Self::Dynamixel(setups, _) => LineServo::Dynamixel((*setups.get(place)?).into()),
            Self::Feetech(setups, _) => LineServo::Feetech(*setups.get(place)?),
            Self::Pulses(setups) => LineServo::Channel(*setups.get(place)?),
        })
    }
}
