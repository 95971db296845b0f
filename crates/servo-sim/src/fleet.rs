//! Creates requested servos, with one line for each bus.

use std::sync::Arc;

use sinew_rig::{Description, Mechanism};
use thiserror::Error;

use crate::bench::{Bench, Branch};
use crate::device::{MEMORY_LEN, Servo, ServoError};
use crate::fault::{Fault, FaultOrder};
use crate::kind::Kind;
use crate::line::{Line, LineDevice};
use crate::load::{Arm, Plant, Push, Shaft};
use crate::model::Parameters;
use crate::plant::RigPlant;
use crate::registers::{RegisterServo, Registers};
use crate::rig::RigServosError;
use crate::supply::Supply;

/// Maximum id of a servo.
const MAX_ID: u8 = 252;

/// A requested servo.
#[derive(Debug, Clone, PartialEq)]
pub struct Wanted {
    /// Name of the bus.
    pub bus: String,
    /// Id of the servo, at most 252.
    pub id: u8,
    /// Name of the servo; empty if it has none.
    pub name: String,
    /// Kind of the servo, with or without physics.
    pub kind: Kind,
    /// Load of the servo.
    pub load: Arm,
    /// Start position, rad, zero where its encoder counts zero; `None` for the middle of the range.
    pub home_rad: Option<f64>,
}

/// Memory for the registers of one servo.
pub type Memory = [u8; MEMORY_LEN];

/// The mechanics that the servos of all buses move.
#[derive(Debug, Clone)]
pub enum Moved {
    /// A separate arm for each servo.
    Arms(Vec<Arm>),
    /// One rig for all servos.
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

    fn step(&mut self, dt_s: f64, pushes: &[Push], shafts: &mut [Shaft]) {
        match self {
            Self::Arms(arms) => arms.step(dt_s, pushes, shafts),
            Self::Rig(rig) => rig.step(dt_s, pushes, shafts),
        }
    }
}

/// Settings that all servos share.
#[derive(Debug, Clone, Default)]
pub struct Setup<'r> {
    /// Baud rate of all servos, bits per second.
    pub baud: u32,
    /// Faults. A fault applies to the servos that have the name in its text; if there are none, to the servos that
    /// have this id.
    pub faults: Vec<FaultOrder>,
    /// Rig that the servos move together, instead of separate loads. The servos must have the names of the rig's
    /// servos.
    pub rig: Option<(&'r Description, &'r Mechanism)>,
    /// Common supply of all servos on all buses. `None`: one stiff supply for each bus, with the voltage of its first
    /// servo.
    pub supply: Option<Supply>,
}

/// The servos of one bus. Servos with physics share plant, supply and time with those of other buses.
pub enum BusServo<'m> {
    /// Servos with physics.
    Servos(Branch<'m, Moved>),
    /// Servos without physics: only registers.
    Registers(Registers<'m>),
}

macro_rules! of {
    ($it:expr, $own:ident => $do:expr) => {
        match $it {
            BusServo::Servos($own) => $do,
            BusServo::Registers($own) => $do,
        }
    };
}

impl LineDevice for BusServo<'_> {
    fn now_ns(&self) -> u64 {
        of!(self, own => own.now_ns())
    }

    fn run_until(&mut self, ns: u64) {
        of!(self, own => own.run_until(ns));
    }

    fn wire_ns(&self, bytes: usize) -> u64 {
        of!(self, own => own.wire_ns(bytes))
    }

    fn set_rate(&mut self, baud: u32) {
        of!(self, own => own.set_rate(baud));
    }

    fn hear(&mut self, bytes: &[u8], speaker: Option<usize>) {
        of!(self, own => own.hear(bytes, speaker));
    }

    fn next_speaker(&self) -> Option<(usize, u32)> {
        of!(self, own => own.next_speaker())
    }

    fn speak(&mut self, speaker: usize) -> Option<(Vec<u8>, u32)> {
        of!(self, own => own.speak(speaker))
    }

    fn silence(&mut self) {
        of!(self, own => own.silence());
    }
}

/// The reason why the servos could not be created.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum FleetError {
    /// The id is too large.
    #[error("id {0}: a servo's id is 0 to {MAX_ID}")]
    Id(u8),
    /// Two servos of a bus have the same id.
    #[error("two servos have id {id}{}: each servo of a bus has an id of its own", on(bus))]
    Twice {
        /// Name of the bus.
        bus: String,
        /// Id of both servos.
        id: u8,
    },
    /// A bus has servos both with and without physics.
    #[error("bus {0:?} has servos with physics and servos without: ask for all of them without")]
    Mixed(String),
    /// A servo could not be created.
    #[error("servo {servo}: {source}")]
    Servo {
        /// Name or id of the servo.
        servo: String,
        /// Cause of the error.
        source: ServoError,
    },
    /// A fault names a servo that does not exist.
    #[error("fault for servo `{found}`: expected one of {expected}")]
    NoServo {
        /// Servo that the fault names.
        found: String,
        /// Servos that exist.
        expected: String,
    },
    /// The rig does not match the servos.
    #[error(transparent)]
    Rig(#[from] Arc<RigServosError>),
    /// The fault needs a motor, a gear or a supply, but the servo has only registers.
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

/// Returns the names of the buses, in the order of their first servos.
pub fn buses(wanted: &[Wanted]) -> Vec<&str> {
    let mut buses: Vec<&str> = Vec::new();
    for servo in wanted {
        if !buses.contains(&servo.bus.as_str()) {
            buses.push(&servo.bus);
        }
    }
    buses
}

/// Creates a line for each bus, in the order of [`buses`]. `memories` must contain one memory for each servo.
///
/// # Errors
/// [`FleetError`] contains the cause.
pub fn lines<'m>(
    wanted: &[Wanted],
    setup: &Setup<'_>,
    memories: &'m mut [Memory],
) -> Result<Vec<Line<BusServo<'m>>>, FleetError> {
    if let Some(servo) = wanted.iter().find(|servo| servo.id > MAX_ID) {
        return Err(FleetError::Id(servo.id));
    }
    let faults = faults(wanted, &setup.faults)?;
    let mut memories: Vec<Option<&'m mut Memory>> = memories.iter_mut().map(Some).collect();
    let mut physical = Physical::default();
    let mut bare = Vec::new();
    for (bus_index, bus) in buses(wanted).into_iter().enumerate() {
        let own: Vec<usize> = (0..wanted.len()).filter(|index| wanted[*index].bus == bus).collect();
        check_ids(bus, own.iter().map(|index| wanted[*index].id))?;
        let is_bare = |index: &&usize| matches!(wanted[**index].kind, Kind::Registers(_));
        let bare_count = own.iter().filter(is_bare).count();
        if bare_count != 0 && bare_count != own.len() {
            return Err(FleetError::Mixed(bus.to_owned()));
        }
        let (first, mut registers) = (physical.servos.len(), Vec::new());
        for index in &own {
            let Some(memory) = memories[*index].take() else { continue };
            let servo = &wanted[*index];
            match &servo.kind {
                Kind::Servo(kind) => {
                    physical.push(servo, (kind, *index, bus_index), setup.baud, memory)?;
                }
                Kind::Registers(table) => registers.push(
                    RegisterServo::new(*table, servo.id, setup.baud, memory)
                        .map_err(|source| FleetError::Servo { servo: servo.label(), source })?,
                ),
            }
        }
        physical.counts.push(physical.servos.len() - first);
        bare.push((bare_count > 0).then(|| {
            let mut registers = Registers::new(registers);
            registers.faults = of_places(&faults, &own);
            registers
        }));
    }
    let branches = physical.branches(setup, &faults)?;
    let on_bus = |(branch, bare): (_, Option<Registers<'m>>)| {
        Line::new(bare.map_or(BusServo::Servos(branch), BusServo::Registers))
    };
    Ok(branches.into_iter().zip(bare).map(on_bus).collect())
}

fn check_ids(bus: &str, ids: impl Iterator<Item = u8>) -> Result<(), FleetError> {
    let mut seen = Vec::new();
    for id in ids {
        if seen.contains(&id) {
            return Err(FleetError::Twice { bus: bus.to_owned(), id });
        }
        seen.push(id);
    }
    Ok(())
}

/// Selects the faults of some servos, and numbers them by their places in `servos`.
fn of_places(faults: &[Fault], servos: &[usize]) -> Vec<Fault> {
    let place = |fault: &Fault| servos.iter().position(|index| *index == fault.servo);
    faults.iter().filter_map(|fault| Some(Fault { servo: place(fault)?, ..*fault })).collect()
}

/// Servos with physics, sorted by bus.
#[derive(Default)]
struct Physical<'m, 'w> {
    servos: Vec<Servo<'m>>,
    arms: Vec<Arm>,
    names: Vec<&'w str>,
    /// Index of each servo among all requested servos.
    indices: Vec<usize>,
    bus_of: Vec<usize>,
    /// Voltage of the first servo of each bus, V.
    voltages: Vec<f64>,
    /// Number of servos on each bus.
    counts: Vec<usize>,
}

impl<'m, 'w> Physical<'m, 'w> {
    fn push(
        &mut self,
        wanted: &'w Wanted,
        (kind, index, bus): (&Parameters, usize, usize),
        baud: u32,
        memory: &'m mut Memory,
    ) -> Result<(), FleetError> {
        let failed = |source| FleetError::Servo { servo: wanted.label(), source };
        let mut servo = Servo::new(kind, wanted.id, memory).map_err(failed)?;
        servo.set_baud(baud).map_err(failed)?;
        if let Some(home_rad) = wanted.home_rad {
            servo.place(home_rad);
        }
        self.servos.push(servo);
        self.arms.push(wanted.load);
        self.names.push(&wanted.name);
        self.indices.push(index);
        // A preceding bus without physics gets a supply that feeds nothing.
        self.voltages.resize((bus + 1).max(self.voltages.len()), kind.voltage_v);
        self.bus_of.push(bus);
        Ok(())
    }

    fn branches(
        self,
        setup: &Setup<'_>,
        faults: &[Fault],
    ) -> Result<Vec<Branch<'m, Moved>>, FleetError> {
        let moved = match setup.rig {
            Some((description, mechanism)) => {
                let plant = RigPlant::new(description, mechanism, &self.names).map_err(Arc::new)?;
                Moved::Rig(Box::new(plant))
            }
            None => Moved::Arms(self.arms),
        };
        let mut bench = if let Some(supply) = &setup.supply {
            Bench::new(self.servos, moved, supply.clone())
        } else {
            let stiff = self.voltages.into_iter().map(Supply::stiff).collect();
            Bench::fed_by_several(self.servos, moved, stiff, |place| self.bus_of[place])
        };
        bench.faults = of_places(faults, &self.indices);
        Ok(Branch::of(bench, &self.counts))
    }
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
        assert_eq!(lines.len(), 2);
        let BusServo::Servos(left) = &lines[0].servos else { panic!("they have physics") };
        let faults: Vec<usize> = left.bench().faults.iter().map(|fault| fault.servo).collect();
        // Sorted by bus: 1, 2, jaw. `1` is not a name, so both servos with this id are late.
        assert_eq!(faults, [2, 1, 0, 2]);
    }

    #[test]
    fn a_bus_of_registers_stands_beside_one_with_physics() {
        let wanted = [
            wanted("bare", 4, "", "scs0009"),
            wanted("bare", 5, "", "scs0009"),
            wanted("main", 1, "", "xl330"),
        ];
        let faults = vec!["5:silent".parse().unwrap()];
        let mut memories = [[0; MEMORY_LEN]; 3];
        let setup = Setup { baud: 1_000_000, faults, ..Setup::default() };
        let lines = lines(&wanted, &setup, &mut memories).unwrap();
        let BusServo::Registers(bare) = &lines[0].servos else { panic!("it has registers only") };
        assert_eq!(bare.faults[0].servo, 1);
        let BusServo::Servos(main) = &lines[1].servos else { panic!("it has physics") };
        assert_eq!(main.bench().servos().len(), 1);
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
