//! Runs controller, bus lines and simulated servos in lockstep, one tick per call.

use std::cell::RefCell;
use std::rc::Rc;

use sinew_core::glam::Quat;
use sinew_core::{JointKind, math};
use sinew_firmware::controller::{Approach, Incomplete, Inputs, Report, Start};
use sinew_firmware::node;
use sinew_firmware::supervisor::{
    Command, Fault, FaultSet, Feed, GuardSettings, Permission, Source,
};
use sinew_servo_bus::dynamixel::table::address;
use sinew_servo_bus::feetech::table::address::TORQUE_ENABLE as FEETECH_TORQUE_ENABLE;
use sinew_servo_bus::{Effort, ServoBus as _};
use sinew_servo_sim::bench::Branch;
use sinew_servo_sim::line::{Line, LineDevice as _, run_all};
use sinew_servo_sim::load::Plant;
use sinew_servo_sim::plant::{Hand, RigPlant};
use sinew_servo_sim::registers::RegisterTable;

use super::bus::Buses;
use super::error::SimulatedRigError;
use super::exchange::exchange;
use super::peer::PeerController;
use super::rig_parts::RigParts;
use super::servo_part::{Drive, single};
use super::simulated_lines::{Memory, lines};
use super::wires::Wires;
use super::{DOFS, RigController, SERVOS};

/// A rig on a stand, with its controller.
pub struct SimulatedRig<'a, P> {
    /// The parts of the rig.
    pub parts: &'a RigParts,
    controller: Box<RigController<'a>>,
    buses: Buses,
    lines: Vec<Line<Branch<'a, P>>>,
    wires: Wires,
    show: Option<&'a [u8]>,
    ticks: u64,
    /// Number of ticks that were not complete; in these a board would not feed its watchdog.
    incomplete: u64,
    last: Option<Incomplete>,
    peer: Option<Rc<RefCell<dyn PeerController>>>,
}

impl<'a, P: Plant> SimulatedRig<'a, P> {
    /// Creates a rig just before power-on, each servo at its angle in the home pose, configured as by `sinew servo
    /// apply`. Without a show there is nothing to play.
    ///
    /// `memories`: one for each servo; `plant`: the mechanism that the servos move, line after line.
    ///
    /// # Errors
    /// [`SimulatedRigError`] if controller or servos cannot be created, or the show does not play on the rig.
    pub fn new(
        parts: &'a RigParts,
        show: Option<&'a [u8]>,
        memories: &'a mut [Memory],
        plant: P,
    ) -> Result<Self, SimulatedRigError> {
        let start = Start::default();
        let controller = RigController::new(
            &parts.board,
            &parts.settings,
            &parts.setups,
            &parts.schedule,
            start,
        )?;
        let mut controller = Box::new(controller);
        controller.load_show(show)?;
        Ok(Self {
            parts,
            controller,
            buses: parts.all_buses()?,
            lines: lines(parts, memories, plant)?,
            wires: Wires::default(),
            show,
            ticks: 0,
            incomplete: 0,
            last: None,
            peer: None,
        })
    }

    /// Gives the servos the packets of a peer, which plays beside the controller in this process.
    #[must_use]
    pub fn with_peer(mut self, peer: Rc<RefCell<dyn PeerController>>) -> Self {
        self.buses = self.buses.with_peer(&peer);
        self.peer = Some(peer);
        self
    }

    /// Runs a tick, in which the host link counts as alive.
    pub fn tick(&mut self, command: Option<Command>) {
        let tick_us = u64::from(self.parts.tick_us());
        let inputs = Inputs {
            now_us: self.ticks * tick_us,
            heard: true,
            command,
            found: FaultSet::EMPTY,
            jog: None,
        };
        self.ticks += 1;
        if let Some(peer) = &self.peer {
            peer.borrow_mut().begin(command);
        }
        let Self { controller, buses, lines, wires, .. } = self;
        let begun = controller.begin(&inputs, &mut (), buses);
        let is_on = controller.permission().torque;
        for line in &mut *lines {
            line.servos.enable_pulses(is_on);
        }
        let begin_ns = lines[0].servos.now_ns();
        let end_ns = self.ticks * tick_us * 1000;
        // The tick's computing takes time: requests outside the schedule must end before it.
        let asked_until_ns =
            end_ns.saturating_sub(u64::from(self.parts.settings.compute_us) * 1000);
        let exchanged = exchange(&mut buses.lines, lines, asked_until_ns, wires);
        let took_us = (lines[0].servos.now_ns() - begin_ns) / 1000;
        let took_us = u32::try_from(took_us)
            .unwrap_or(u32::MAX)
            .saturating_add(self.parts.settings.compute_us);
        let ended = controller.end(begun, exchanged, took_us);
        if let Some(peer) = &self.peer {
            peer.borrow_mut().end(took_us, ended.is_ok(), controller);
        }
        match ended {
            Ok(_) => {}
            Err(why) => {
                self.incomplete += 1;
                self.last = Some(why);
            }
        }
        run_all(lines, end_ns);
    }

    /// Returns the report of the last tick.
    pub fn report(&self) -> &Report<DOFS, SERVOS> {
        self.controller.report()
    }

    /// Returns a fault in words, with its joint and servo.
    pub fn named(&self, fault: Fault) -> String {
        let mut kept = self.controller.supervisor().log().last();
        let servo = kept.find(|record| record.fault == fault).and_then(|record| record.servo);
        let servo = servo.map(usize::from);
        let Some((servo, part)) = servo.and_then(|at| Some((at, self.parts.servos.get(at)?)))
        else {
            return fault.to_string();
        };
        let joints = self.parts.names.iter().zip(&self.parts.first_servo);
        let joint = joints.filter(|(_, first)| **first == Some(servo)).map(|(name, _)| name).next();
        let joint = joint.map_or_else(String::new, |joint| format!("joint {joint}, "));
        format!("{fault} of {joint}servo {}", part.own.name)
    }

    /// Returns what the controller permits the drives to do.
    pub fn permission(&self) -> &Permission {
        self.controller.permission()
    }

    /// Computes the way from the commanded pose to the beginning of the show; `None` without a show.
    pub fn approach(&self) -> Option<Approach> {
        self.parts.approach(self.show?, self.controller.commanded().0)
    }

    /// Returns whether the show ran in the last tick.
    pub fn runs(&self) -> bool {
        let permission = self.permission();
        permission.source == Source::Feed(Feed::Show) && permission.runs
    }

    /// Returns commanded and measured position of each dof; for a ball joint the rotation vector. If servos report
    /// nothing, the commanded position counts as measured: see [`RigParts::tells_nothing`].
    pub fn dofs(&self) -> [Vec<f32>; 2] {
        let q = [self.controller.commanded().0, self.controller.measured()];
        q.map(|q| self.positions(q))
    }

    /// Converts coordinates of the rig to positions of dofs.
    fn positions(&self, mut q: &[f32]) -> Vec<f32> {
        let mut positions = Vec::new();
        for body in self.parts.board.tree().bodies() {
            let kind = body.joint;
            let (own, rest) = q.split_at(kind.coordinate_count().min(q.len()));
            q = rest;
            match (kind, own) {
                (JointKind::Spherical, &[x, y, z, w]) => {
                    positions.extend(math::log(Quat::from_xyzw(x, y, z, w)).to_array());
                }
                // A free joint, whose coordinates are different, is refused earlier.
                _ => positions.extend_from_slice(own),
            }
        }
        positions
    }

    /// Returns the last measurement, in the rig's coordinates.
    pub fn measured(&self) -> &[f32] {
        self.controller.measured()
    }

    /// Returns the current that a servo reports, A. A reported load is converted: it is a share of the stall current,
    /// or for a servo driven by voltage the share of the supply voltage, from which the back-EMF is subtracted (0 while
    /// torque is not permitted). `None` without a reading.
    pub fn current_a(&self, servo: usize) -> Option<f32> {
        let read = self.buses.feedback(servo)?;
        Some(match read.effort {
            Effort::Current(current_a) => current_a,
            Effort::Load(part) => {
                let setup = &self.parts.setups[servo];
                let guard =
                    GuardSettings::of(&self.parts.board.servos()[servo].servo, &setup.drive);
                let supply_v = self.buses.health(servo).and_then(|health| health.voltage_v);
                match guard.winding_a(part, &read, supply_v) {
                    Some(_) if !self.controller.permission().torque => 0.0,
                    Some(current_a) => current_a,
                    None => part * setup.stall_a,
                }
            }
        })
    }

    /// Returns the limit that acts on a joint now, for tables, recordings and telemetry: a limit of its effort, of its
    /// first servo's drive, or of heat and supply. If none of these acts, returns the limit of the guard, or `None` if
    /// the guard limits nothing.
    pub fn limiter(&self, dof: usize) -> Option<String> {
        let report = self.report();
        let servo = self.parts.first_servo[dof].map(|servo| &report.servos[servo]);
        let limiter = node::limiter(&report.dofs[dof], servo).map(|limit| limit.name().to_owned());
        let guard = || Some(format!("{:?}", servo?.guard?).to_lowercase());
        limiter.or_else(guard)
    }

    /// Returns whether every servo that reports its state has reported its temperature. Before that, drives give no
    /// effort.
    pub fn is_known(&self) -> bool {
        let mut all = self.report().servos.iter().zip(&self.parts.servos);
        all.all(|(told, part)| part.drive == Drive::Pulses || told.temperature_c.is_some())
    }

    /// Returns the number of ticks since power-on.
    pub fn ticks(&self) -> u64 {
        self.ticks
    }

    /// Returns the simulated time since power-on, s.
    pub fn time_s(&self) -> f64 {
        1e-6 * (self.ticks * u64::from(self.parts.tick_us())) as f64
    }

    /// Returns the number of incomplete ticks, and the reason for the last one; `None` if there was none.
    pub fn incomplete(&self) -> (u64, Option<Incomplete>) {
        (self.incomplete, self.last)
    }

    /// Returns the traffic on the wires.
    pub fn wires(&self) -> Wires {
        self.wires
    }

    /// Sets a register of a simulated servo, as another program might before power-on.
    #[cfg(test)]
    pub(super) fn set_register(&mut self, servo: usize, register: u16, raw: i32) {
        let place = self.parts.place_on_bench(servo);
        self.lines[0].servos.bench_mut().servos_mut()[place].set(register, raw);
    }

    /// Returns the number of simulated servos with torque on, by their registers or because they get pulses.
    pub fn servos_on(&self) -> usize {
        let on = |servo: &usize| {
            let part = &self.parts.servos[*servo];
            let bench = self.lines[0].servos.bench();
            let simulated = &bench.servos()[self.parts.place_on_bench(*servo)];
            let register = match RegisterTable::of(&part.own.kind.name) {
                Some(RegisterTable::Dynamixel(_)) => address::TORQUE_ENABLE,
                Some(RegisterTable::Feetech(_)) => FEETECH_TORQUE_ENABLE.into(),
                None => return simulated.pulse_us().is_some(),
            };
            simulated.get(register) == 1
        };
        (0..self.parts.servos.len()).filter(on).count()
    }
}

impl SimulatedRig<'_, RigPlant> {
    /// Makes a hand hold a joint's dof, or lead it further. `None`: the hand releases it. See [`RigPlant::lead`].
    pub fn lead(&mut self, dof: usize, hand: Option<Hand>) -> bool {
        self.lines[0].servos.bench_mut().plant.lead(dof, hand)
    }

    /// Applies an external torque or force to a dof, N m or N, until the next call. See [`RigPlant::push`].
    pub fn push(&mut self, dof: usize, torque_nm: f64) -> bool {
        self.lines[0].servos.bench_mut().plant.push(dof, torque_nm)
    }

    /// Returns the true position of the simulated rig, in its coordinates.
    pub fn q(&self) -> Vec<f64> {
        self.lines[0].servos.bench().plant.q().to_vec()
    }

    /// Returns the true temperature of a servo's case, °C, with finer resolution than the servo reports.
    pub fn case_c(&self, servo: usize) -> f64 {
        let place = self.parts.place_on_bench(servo);
        self.lines[0].servos.bench().servos()[place].heat().case_c
    }

    /// Returns the power that is lost in a servo's winding, W. No servo reports it.
    pub fn winding_w(&self, servo: usize) -> f64 {
        let place = self.parts.place_on_bench(servo);
        self.lines[0].servos.bench().servos()[place].lost_w()[0]
    }

    /// Returns each dof's true position minus its commanded one, rad or m. No servo measures it.
    pub fn simulated_errors(&self) -> Vec<f32> {
        let q: Vec<f32> = self.q().into_iter().map(single).collect();
        let commanded = self.positions(self.controller.commanded().0);
        commanded.iter().zip(self.positions(&q)).map(|(sent, is)| is - sent).collect()
    }
}
