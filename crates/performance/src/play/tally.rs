//! Results of a performance: following errors, currents, temperatures, by joint and by drive.

use std::collections::BTreeMap;

use comfy_table::Table;
use sinew_firmware::supervisor::{Fault, FaultSet};
use sinew_host_util::command::table;
use sinew_servo_sim::load::Plant;
use sinew_servo_sim::plant::RigPlant;

use super::rig_parts::RigParts;
use super::servo_part::Drive;
use super::simulated_rig::SimulatedRig;
use super::swing_meter::SwingMeter;

/// Sums of one dof, over the ticks in which the show runs.
#[derive(Debug, Clone)]
struct Sums {
    error: f64,
    largest: f64,
    largest_s: f64,
    effort: f64,
    current_a: f64,
    celsius: f64,
    /// Number of ticks in which each limit acted.
    limited: BTreeMap<String, u64>,
    swing: SwingMeter,
    /// Whether the controller has detected that the dof swings, at any time.
    is_swinging: bool,
}

/// Sums over all ticks in which a show runs.
#[derive(Debug)]
pub struct Tally {
    dofs: Vec<Sums>,
    ticks: u64,
    /// Whether any joint has servos that report nothing.
    tells_nothing: bool,
}

/// Mean and largest following error of some dofs that turn, rad.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Number of dofs.
    pub joints: usize,
    /// Mean absolute error, over dofs and ticks.
    pub mean_rad: f64,
    /// The largest absolute error.
    pub most_rad: f64,
    /// The dof with the largest error.
    pub dof: usize,
    /// Time of the largest error in the play, s.
    pub at_s: f64,
}

impl Tally {
    /// Creates a tally for a rig.
    pub fn new(parts: &RigParts) -> Self {
        let count = parts.names.len();
        let tells_nothing = (0..count).any(|dof| parts.tells_nothing(dof));
        let sums = Sums {
            error: 0.0,
            largest: 0.0,
            largest_s: 0.0,
            effort: 0.0,
            current_a: 0.0,
            celsius: 0.0,
            limited: BTreeMap::new(),
            swing: SwingMeter::new(parts.rate_hz.into()),
            is_swinging: false,
        };
        Self { dofs: vec![sums; count], ticks: 0, tells_nothing }
    }

    /// Adds a tick. Servos on pulses report nothing: their error is taken from the simulated rig.
    pub fn note(&mut self, sim: &SimulatedRig<'_, RigPlant>) {
        let report = sim.report();
        for (sums, dof) in self.dofs.iter_mut().zip(&report.dofs) {
            sums.is_swinging |= dof.swings;
        }
        if !sim.runs() {
            return;
        }
        let time_s = self.ticks as f64 / f64::from(sim.parts.rate_hz);
        self.ticks += 1;
        let simulated = if self.tells_nothing { sim.simulated_errors() } else { Vec::new() };
        for (index, (sums, dof)) in self.dofs.iter_mut().zip(&report.dofs).enumerate() {
            let tells_nothing = sim.parts.tells_nothing(index);
            let error = if tells_nothing { simulated[index] } else { dof.error };
            sums.swing.note(error.into());
            let error = f64::from(error.abs());
            sums.error += error;
            if error > sums.largest {
                (sums.largest, sums.largest_s) = (error, time_s);
            }
            sums.effort = sums.effort.max(f64::from(dof.effort.abs()));
            let Some(servo) = sim.parts.first_servo[index] else { continue };
            let current_a = sim.current_a(servo).map_or(0.0, |a| f64::from(a.abs()));
            sums.current_a = sums.current_a.max(current_a);
            let told = &report.servos[servo];
            sums.celsius = sums.celsius.max(told.temperature_c.map_or(0.0, f64::from));
            if let Some(limiter) = sim.limiter(index) {
                *sums.limited.entry(limiter).or_default() += 1;
            }
        }
    }

    /// Returns the number of ticks in which the show ran.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Returns the errors of dofs that turn and whose servos have this drive; with `None`, of all driven dofs that
    /// turn. Returns `None` if there is no such dof, or nothing was played.
    pub fn errors(&self, parts: &RigParts, drive: Option<Drive>) -> Option<Errors> {
        let mut errors = Errors { joints: 0, mean_rad: 0.0, most_rad: 0.0, dof: 0, at_s: 0.0 };
        for (dof, sums) in self.dofs.iter().enumerate() {
            let of = parts.drives[dof];
            if parts.slides[dof] || of.is_none() || drive.is_some_and(|d| of != Some(d)) {
                continue;
            }
            errors.joints += 1;
            errors.mean_rad += sums.error;
            if sums.largest > errors.most_rad {
                errors.most_rad = sums.largest;
                (errors.dof, errors.at_s) = (dof, sums.largest_s);
            }
        }
        let count = errors.joints as f64 * self.ticks as f64;
        errors.mean_rad /= count;
        (count > 0.0).then_some(errors)
    }

    /// Returns the tables at the end of a run.
    pub fn table<P: Plant>(&self, sim: &SimulatedRig<'_, P>, raised: FaultSet) -> String {
        let parts = sim.parts;
        let (by_drive, by_joint) = (self.by_drive(parts), self.by_joint(parts));
        let faults = raised.minus(FaultSet::WARNINGS).iter();
        let faults: Vec<String> = faults.map(|fault| sim.named(fault)).collect();
        let faults = if faults.is_empty() { "none".to_owned() } else { faults.join(", ") };
        let found = match raised.and(FaultSet::WARNINGS).iter().count() {
            0 => String::new(),
            1 => ", 1 warning".to_owned(),
            count => format!(", {count} warnings"),
        };
        let warnings = self.warnings(parts);
        let wires = sim.wires();
        let (incomplete, why) = sim.incomplete();
        let why = why.map_or_else(String::new, |why| format!(" ({why})"));
        let pulses = if self.tells_nothing {
            "Servos driven by pulses report nothing: their error is that of the simulated rig, and is unknown on a \
             real rig.\n"
        } else {
            ""
        };
        format!(
            "Following error while the show ran, {:.2} s; angles in deg, ways in mm, `at s` from its start.\n{pulses}{by_drive}\n{by_joint}\n\
             faults: {faults}{found}\n{warnings}ticks: {} of {:.2} ms, {} overruns, {incomplete} not whole{why}\n\
             wire: {} bytes sent, {} answered, hash {:016x}\n",
            self.ticks as f64 / f64::from(parts.rate_hz),
            sim.ticks(),
            1e-3 * f64::from(parts.tick_us()),
            sim.report().overruns,
            wires.sent,
            wires.answered,
            wires.hash,
        )
    }

    /// Returns a line that names the joints that swing.
    fn warnings(&self, parts: &RigParts) -> String {
        let dofs = self.dofs.iter().zip(&parts.names);
        let joints: Vec<&str> =
            dofs.filter(|(sums, _)| sums.is_swinging).map(|(_, name)| name.as_str()).collect();
        if joints.is_empty() {
            return String::new();
        }
        format!("{}: {}\n", Fault::Swing, joints.join(", "))
    }

    fn by_drive(&self, parts: &RigParts) -> String {
        let header = ["drive", "method", "joints", "mean", "largest", "of joint", "at s"];
        let mut table = table(header, 2..header.len());
        let known = Drive::ALL;
        let all = known.into_iter().map(Some).chain([None]);
        let found: Vec<_> = all.map(|drive| (drive, self.errors(parts, drive))).collect();
        let is_mixed =
            found[..known.len()].iter().filter(|(_, errors)| errors.is_some()).count() > 1;
        for (drive, errors) in found {
            let Some(errors) = errors else { continue };
            if drive.is_none() && !is_mixed {
                continue;
            }
            table.add_row([
                drive.map_or("all", Drive::name).to_owned(),
                parts.method().as_str().to_owned(),
                errors.joints.to_string(),
                format!("{:.2}", errors.mean_rad.to_degrees()),
                format!("{:.2}", errors.most_rad.to_degrees()),
                parts.names[errors.dof].clone(),
                format!("{:.2}", errors.at_s),
            ]);
        }
        lines(&table)
    }

    fn by_joint(&self, parts: &RigParts) -> String {
        let header = [
            "joint",
            "drive",
            "mean",
            "largest",
            "at s",
            "effort N m",
            "current A",
            "celsius",
            "swing",
            "limited",
        ];
        let mut table = table(header, 2..header.len());
        for (dof, sums) in self.dofs.iter().enumerate() {
            let Some(drive) = parts.drives[dof] else { continue };
            let shown = |x: f64| {
                let number = if parts.slides[dof] { 1000.0 * x } else { x.to_degrees() };
                format!("{number:.2}")
            };
            let ticks = self.ticks.max(1) as f64;
            // Such a servo reports nothing, and no effort is commanded.
            let known = |number| if drive == Drive::Pulses { "-".to_owned() } else { number };
            table.add_row([
                parts.names[dof].clone(),
                drive.name().to_owned(),
                shown(sums.error / ticks),
                shown(sums.largest),
                format!("{:.2}", sums.largest_s),
                known(format!("{:.3}", sums.effort)),
                known(format!("{:.2}", sums.current_a)),
                known(format!("{:.0}", sums.celsius)),
                known(shown(sums.swing.peak_to_peak())),
                limited(&sums.limited, ticks),
            ]);
        }
        lines(&table)
    }
}

/// Returns the share of ticks in which a limit acted on a joint, and the most frequent limit.
fn limited(by: &BTreeMap<String, u64>, ticks: f64) -> String {
    let share = 100.0 * by.values().sum::<u64>() as f64 / ticks;
    let most = by.iter().max_by_key(|(_, count)| **count);
    most.map_or_else(|| "0 %".to_owned(), |(limiter, _)| format!("{share:.0} % {limiter}"))
}

/// Formats a table without blanks at the ends of lines.
pub(super) fn lines(table: &Table) -> String {
    table.lines().flat_map(|line| [line.trim_end().to_owned(), "\n".to_owned()]).collect()
}
