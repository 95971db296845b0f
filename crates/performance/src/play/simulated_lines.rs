//! Creates the bus lines of a rig with simulated servos.

use sinew_servo_bus::settings;
use sinew_servo_sim::bench::{Bench, Branch};
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::line::Line;
use sinew_servo_sim::load::Plant;
use sinew_servo_sim::registers::RegisterTable;

use super::error::SimulatedRigError;
use super::pulses;
use super::rig_parts::RigParts;
use super::servo_part::ServoPart;

/// Registers of one servo.
pub type Memory = [u8; MEMORY_LEN];

impl RigParts {
    /// Creates the lines of a rig with simulated servos, each at its angle in the rig's home pose, configured as by
    /// `sinew servo apply`.
    ///
    /// `memories`: one for each servo; `plant`: the mechanism that they move, line after line.
    ///
    /// # Errors
    /// [`SimulatedRigError`] names the servo.
    pub fn simulated<'a, P: Plant>(
        &self,
        memories: &'a mut [Memory],
        plant: P,
    ) -> Result<Vec<Line<Branch<'a, P>>>, SimulatedRigError> {
        lines(self, memories, plant)
    }
}

/// Creates the lines of a rig, each servo at its angle in the rig's home pose, configured as by `sinew servo apply`.
pub(super) fn lines<'a, P: Plant>(
    parts: &RigParts,
    memories: &'a mut [Memory],
    plant: P,
) -> Result<Vec<Line<Branch<'a, P>>>, SimulatedRigError> {
    let mut servos: Vec<Vec<Servo>> = parts.lines.iter().map(|_| Vec::new()).collect();
    for (index, memory) in (0..parts.servos.len()).zip(memories) {
        servos[parts.servos[index].place.0].push(servo(parts, index, memory)?);
    }
    let counts: Vec<usize> = servos.iter().map(Vec::len).collect();
    let line_of = |place| {
        let mut end = 0;
        let ends = counts.iter().map(|count| {
            end += count;
            end
        });
        ends.take_while(|end| *end <= place).count()
    };
    let servos = servos.into_iter().flatten().collect();
    let bench = match parts.supply() {
        Some(supply) => Bench::new(servos, plant, supply),
        None => Bench::fed_by_several(servos, plant, parts.stiff_supplies(), line_of),
    };
    let mut branches = Branch::of(bench, &counts);
    for (branch, line) in branches.iter_mut().zip(&parts.lines) {
        if line.is_of_pulses() {
            let own: Vec<&ServoPart> = line.servos.iter().map(|at| &parts.servos[*at]).collect();
            branch.put_chip(pulses::chip(&own), line.baud);
            branch.start_chip(pulses::prescale());
        }
    }
    Ok(branches.into_iter().map(Line::of_master).collect())
}

/// Creates a servo at home, with the registers that the controller compares before it arms.
fn servo<'a>(
    parts: &RigParts,
    index: usize,
    memory: &'a mut Memory,
) -> Result<Servo<'a>, SimulatedRigError> {
    let part = &parts.servos[index];
    let failed = |reason| SimulatedRigError::Servo { servo: part.own.name.clone(), reason };
    let Some(id) = part.own.id() else {
        let mut servo = Servo::on_pulses(&part.own.kind);
        servo.place(part.own.home_rad);
        return Ok(servo);
    };
    let mut servo = Servo::new(&part.own.kind, id, memory).map_err(failed)?;
    servo.set_baud(parts.lines[part.place.0].baud).map_err(failed)?;
    let requirements = parts.setups[index].requirements(&parts.board.servos()[index].servo);
    let mut set = |setting: settings::Setting| servo.set(setting.item.address, setting.raw);
    match RegisterTable::of(&part.own.kind.name) {
        Some(RegisterTable::Dynamixel(table)) => {
            settings::dynamixel(table, requirements).for_each(&mut set);
        }
        Some(RegisterTable::Feetech(table)) => {
            settings::feetech(table.model.family, requirements).for_each(&mut set);
        }
        // `RigParts` has refused models that have an id but no registers.
        None => {}
    }
    servo.place(part.own.home_rad);
    Ok(servo)
}
