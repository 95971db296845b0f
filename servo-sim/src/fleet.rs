//! Servos as somebody wants them, on one line for each bus.

#[cfg(unix)]
use std::{io, sync::atomic::AtomicBool};

use std::sync::Arc;

use sinew_rig::{Description, Mechanism};
use thiserror::Error;

use crate::bench::Bench;
use crate::device::{MEMORY_LEN, Servo, ServoError};
use crate::fault::{Fault, FaultOrder};
use crate::kind::Kind;
use crate::line::Line;
use crate::load::{Arm, Plant, Shaft};
use crate::plant::RigPlant;
#[cfg(unix)]
use crate::port::Port;
use crate::registers::{RegisterServo, Registers};
use crate::rig::RigServosError;
use crate::supply::Supply;

/// The highest id of a servo.
const MAX_ID: u8 = 252;

/// A servo that somebody wants.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Its bus.
    pub bus: String,
    /// Its id, at most 252.
    pub id: u8,
    /// What people call it; empty if it has no name.
    pub name: String,
    /// What is simulated of it.
    pub kind: Kind,
    /// What it moves, if it moves anything.
    pub load: Arm,
    /// Where it begins, rad from where its encoder counts zero; none for the middle of its range.
    pub home_rad: Option<f64>,
}

/// Registers of one servo.
pub type Memory = [u8; MEMORY_LEN];

/// What the servos of a bus move.
#[derive(Debug, Clone)]
pub enum Moved {
    /// Each its own.
    Arms(Vec<Arm>),
    /// A rig.
    Rig(Box<RigPlant>),
}

impl Plant for Moved {
    type Load = Arm;

    fn load(&self, servo: usize) -> Arm {
        match self {
            Self::Arms(arms) => arms.load(servo),
            Self::Rig(rig) => rig.load(servo),
        }
    }

    fn servo_steps(&self) -> u32 {
        match self {
            Self::Arms(arms) => arms.servo_steps(),
            Self::Rig(rig) => rig.servo_steps(),
        }
    }

    fn step(&mut self, dt_s: f64, torques_nm: &[f64], shafts: &mut [Shaft]) {
        match self {
            Self::Arms(arms) => arms.step(dt_s, torques_nm, shafts),
            Self::Rig(rig) => rig.step(dt_s, torques_nm, shafts),
        }
    }
}

/// What is the same for all servos.
#[derive(Debug, Clone, Default)]
pub struct Setup<'r> {
    /// Bits per second that all are set to.
    pub baud: u32,
    /// What goes wrong. A fault is for the servos of that name, else for those of that id.
    pub faults: Vec<FaultOrder>,
    /// The rig that they move together, instead of what each moves by itself: they have the names of its servos.
    pub rig: Option<(&'r Description, &'r Mechanism)>,
    /// What feeds the servos of a bus, each bus by one of its own. None: a stiff one of the first servo's voltage.
    pub supply: Option<Supply>,
}

/// All servos of one bus.
pub enum BusLine<'m> {
    /// With physics.
    Servos(Line<Bench<'m, Moved>>),
    /// Without.
    Registers(Line<Registers<'m>>),
}

/// Why the servos cannot be had.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum FleetError {
    /// An id is too high.
    #[error("id {0}: a servo's id is 0 to {MAX_ID}")]
    Id(u8),
    /// Two servos of a bus have one id.
    #[error("two servos have id {id}{}: each servo of a bus has an id of its own", on(bus))]
    Twice {
        /// The bus.
        bus: String,
        /// The id.
        id: u8,
    },
    /// A bus has servos with and without physics.
    #[error("bus {0:?} has servos with physics and servos without: ask for all of them without")]
    Mixed(String),
    /// A servo cannot be.
    #[error("servo {servo}: {source}")]
    Servo {
        /// Which.
        servo: String,
        /// Why.
        source: ServoError,
    },
    /// A fault is for a servo that there is not.
    #[error("fault for servo `{found}`: expected one of {expected}")]
    NoServo {
        /// Which is asked for.
        found: String,
        /// Those that there are.
        expected: String,
    },
    /// The rig does not take them.
    #[error(transparent)]
    Rig(#[from] Arc<RigServosError>),
    /// A fault needs a motor, a gear or a supply.
    #[error(
        "fault for servo `{0}`: it has registers only; it can be silent, late, wrong-crc, short or wrong-id"
    )]
    NeedsPhysics(String),
}

fn on(bus: &str) -> String {
    if bus.is_empty() { String::new() } else { format!(" on bus {bus:?}") }
}

impl Wanted {
    fn label(&self) -> String {
        if self.name.is_empty() { self.id.to_string() } else { self.name.clone() }
    }
}

/// Names of the buses, in the order in which they come.
pub fn buses(wanted: &[Wanted]) -> Vec<&str> {
    let mut buses: Vec<&str> = Vec::new();
    for servo in wanted {
        if !buses.contains(&servo.bus.as_str()) {
            buses.push(&servo.bus);
        }
    }
    buses
}

/// A line for each bus, in the order of [`buses`]. `memories`: one for each servo.
///
/// # Errors
/// [`FleetError`].
pub fn lines<'m>(
    wanted: &[Wanted],
    setup: &Setup<'_>,
    memories: &'m mut [Memory],
) -> Result<Vec<BusLine<'m>>, FleetError> {
    if let Some(servo) = wanted.iter().find(|servo| servo.id > MAX_ID) {
        return Err(FleetError::Id(servo.id));
    }
    let faults = faults(wanted, &setup.faults)?;
    let mut memories: Vec<Option<&'m mut Memory>> = memories.iter_mut().map(Some).collect();
    let mut lines = Vec::new();
    for bus in buses(wanted) {
        let mut own = Vec::new();
        for (index, (servo, memory)) in wanted.iter().zip(&mut memories).enumerate() {
            if servo.bus != bus {
                continue;
            }
            if own.iter().any(|(_, other, _): &(usize, &Wanted, _)| other.id == servo.id) {
                return Err(FleetError::Twice { bus: bus.to_owned(), id: servo.id });
            }
            if let Some(memory) = memory.take() {
                own.push((index, servo, memory));
            }
        }
        // By place on this bus.
        let place = |fault: &Fault| own.iter().position(|(index, ..)| *index == fault.servo);
        let faults = faults
            .iter()
            .filter_map(|fault| Some(Fault { servo: place(fault)?, ..*fault }))
            .collect();
        lines.push(line(own.into_iter().map(|(_, servo, memory)| (servo, memory)), setup, faults)?);
    }
    Ok(lines)
}

fn faults(wanted: &[Wanted], orders: &[FaultOrder]) -> Result<Vec<Fault>, FleetError> {
    let mut faults = Vec::new();
    for order in orders {
        let named = |servo: &Wanted| servo.name == order.servo;
        let numbered = |servo: &Wanted| order.servo.parse() == Ok(servo.id);
        let is_name = wanted.iter().any(named);
        let before = faults.len();
        for (index, servo) in wanted.iter().enumerate() {
            if if is_name { named(servo) } else { numbered(servo) } {
                if matches!(servo.kind, Kind::Registers(_)) && !order.kind.is_of_replies() {
                    return Err(FleetError::NeedsPhysics(servo.label()));
                }
                faults.push(order.of(index));
            }
        }
        if faults.len() == before {
            let known: Vec<String> = wanted.iter().map(Wanted::label).collect();
            let (found, expected) = (order.servo.clone(), known.join(", "));
            return Err(FleetError::NoServo { found, expected });
        }
    }
    Ok(faults)
}

fn line<'m, 'w>(
    servos: impl Iterator<Item = (&'w Wanted, &'m mut Memory)>,
    setup: &Setup<'_>,
    faults: Vec<Fault>,
) -> Result<BusLine<'m>, FleetError> {
    let (mut whole, mut loads, mut registers) = (Vec::new(), Vec::new(), Vec::new());
    let (mut voltage_v, mut bus, mut names) = (None, "", Vec::new());
    for (wanted, memory) in servos {
        bus = &wanted.bus;
        let failed = |source| FleetError::Servo { servo: wanted.label(), source };
        match &wanted.kind {
            Kind::Servo(kind) => {
                let mut servo = Servo::new(kind, wanted.id, memory).map_err(failed)?;
                servo.set_baud(setup.baud).map_err(failed)?;
                if let Some(home_rad) = wanted.home_rad {
                    servo.place(home_rad);
                }
                voltage_v.get_or_insert(kind.voltage_v);
                whole.push(servo);
                loads.push(wanted.load);
                names.push(wanted.name.as_str());
            }
            Kind::Registers(table) => {
                let servo =
                    RegisterServo::new(*table, wanted.id, setup.baud, memory).map_err(failed)?;
                registers.push(servo);
            }
        }
    }
    match voltage_v {
        Some(_) if !registers.is_empty() => Err(FleetError::Mixed(bus.to_owned())),
        Some(voltage_v) => {
            let moved = match setup.rig {
                Some((description, mechanism)) => {
                    let plant = RigPlant::new(description, mechanism, &names).map_err(Arc::new)?;
                    Moved::Rig(Box::new(plant))
                }
                None => Moved::Arms(loads),
            };
            let supply = setup.supply.clone().unwrap_or_else(|| Supply::stiff(voltage_v));
            let mut bench = Bench::new(whole, moved, supply);
            bench.faults = faults;
            Ok(BusLine::Servos(Line::new(bench)))
        }
        None => {
            let mut registers = Registers::new(registers);
            registers.faults = faults;
            Ok(BusLine::Registers(Line::new(registers)))
        }
    }
}

#[cfg(unix)]
impl BusLine<'_> {
    /// Lets programs talk to the servos: see [`Port::serve`].
    ///
    /// # Errors
    /// What the system says.
    pub fn serve(&mut self, port: &Port, stop: &AtomicBool) -> io::Result<()> {
        match self {
            Self::Servos(line) => port.serve(line, stop),
            Self::Registers(line) => port.serve(line, stop),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wanted(bus: &str, id: u8, name: &str, kind: &str) -> Wanted {
        let kind = Kind::named(kind).unwrap();
        let (bus, name) = (bus.to_owned(), name.to_owned());
        Wanted { bus, id, name, kind, load: Arm::default(), home_rad: None }
    }

    fn refused(wanted: &[Wanted], baud: u32, orders: &[&str]) -> String {
        let faults = orders.iter().map(|order| order.parse().unwrap()).collect();
        let mut memories = vec![[0; MEMORY_LEN]; wanted.len()];
        lines(wanted, &Setup { baud, faults, ..Setup::default() }, &mut memories)
            .err()
            .unwrap()
            .to_string()
    }

    #[test]
    fn each_bus_has_a_line_and_its_own_faults() {
        let wanted = [
            wanted("left", 1, "", "xl330"),
            wanted("right", 1, "jaw", "sts3215"),
            wanted("left", 2, "2", "xl330"),
        ];
        assert_eq!(buses(&wanted), ["left", "right"]);
        let faults = ["jaw:stuck", "2:hot", "1:late"].map(|order| order.parse().unwrap()).to_vec();
        let mut memories = [[0; MEMORY_LEN]; 3];
        let setup = Setup { baud: 1_000_000, faults, ..Setup::default() };
        let lines = lines(&wanted, &setup, &mut memories).unwrap();
        let faults: Vec<Vec<usize>> = lines
            .iter()
            .map(|line| match line {
                BusLine::Servos(line) => {
                    line.servos.faults.iter().map(|fault| fault.servo).collect()
                }
                BusLine::Registers(_) => panic!("they have physics"),
            })
            .collect();
        // `1` is no name, so both servos of that id are late.
        assert_eq!(faults, [vec![1, 0], vec![0, 0]]);
    }

    #[test]
    fn what_cannot_be_is_refused_with_what_could() {
        let two = [wanted("", 1, "", "xl330"), wanted("", 1, "", "xl330")];
        assert_eq!(
            refused(&two, 57_600, &[]),
            "two servos have id 1: each servo of a bus has an id of its own"
        );
        let one = [wanted("main", 7, "neck", "xl330")];
        assert!(refused(&one, 12_345, &[]).contains("servo neck: it cannot be set to 12345"));
        let unknown = refused(&one, 57_600, &["jaw:silent"]);
        assert_eq!(unknown, "fault for servo `jaw`: expected one of neck");
        let bare = [wanted("", 7, "", "scs0009")];
        assert!(refused(&bare, 1_000_000, &["7:stuck"]).contains("it has registers only"));
        let mixed = [wanted("a", 1, "", "sts3215"), wanted("a", 2, "", "scs0009")];
        assert!(refused(&mixed, 1_000_000, &[]).contains("ask for all of them without"));
        assert!(refused(&[wanted("", 253, "", "xl330")], 57_600, &[]).contains("0 to 252"));
    }
}
