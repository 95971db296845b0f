//! Which commands a performance gets, and when it is over.

use sinew_firmware::supervisor::{Command, FaultSet, Feed, Moving, Refused, State};
use sinew_servo_sim::load::Plant;

use super::simulated_rig::SimulatedRig;

/// For so long after power-on a rig may not be ready, s.
const READY_S: f64 = 5.0;

/// How a performance ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The show was over, and the rig is limp.
    Done,
    /// Somebody stopped it, and the rig is limp.
    Stopped,
    /// These faults ended it; torque is off.
    Faults(FaultSet),
    /// A command was refused.
    Refused(Refused),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    PowerOn,
    Arming,
    Playing,
    Stopping,
}

/// Arms a rig, plays its show, stops it.
#[derive(Debug)]
pub struct Director {
    phase: Phase,
    raised: FaultSet,
    refused: Option<Refused>,
    is_stopped: bool,
    /// What it waits for before it arms.
    waits_for: Option<Moving>,
}

impl Default for Director {
    fn default() -> Self {
        let (refused, waits_for) = (None, None);
        let (phase, raised) = (Phase::PowerOn, FaultSet::EMPTY);
        Self { phase, raised, refused, is_stopped: false, waits_for }
    }
}

impl Director {
    /// All faults and warnings that came.
    pub fn raised(&self) -> FaultSet {
        self.raised
    }

    /// Those of them that end a performance.
    fn faults(&self) -> FaultSet {
        self.raised.minus(FaultSet::WARNINGS)
    }

    /// The joint that it waits for to rest before it arms the rig.
    pub fn waits_for(&self) -> Option<Moving> {
        self.waits_for
    }

    /// A tick of a stand. `stop`: somebody wants the rig to stop. Says how it ended, when torque is off for good.
    pub fn tick<P: Plant>(&mut self, sim: &mut SimulatedRig<'_, P>, stop: bool) -> Option<Ended> {
        let command = self.command(sim, stop);
        sim.tick(command);
        let report = sim.report();
        self.raised = self.raised.union(report.raised);
        let refused = command.and(report.answer).and_then(Result::err);
        match (self.phase, report.state) {
            (_, State::Faulted) => return Some(Ended::Faults(self.faults())),
            // Torque is off.
            (Phase::Stopping, State::Limp | State::Off) => {}
            (Phase::PowerOn, _) if sim.time_s() < READY_S => return None,
            (Phase::PowerOn, _) => return refused.map(Ended::Refused),
            _ => {
                self.refused = self.refused.or(refused);
                return None;
            }
        }
        Some(match self.refused {
            _ if !self.faults().is_empty() => Ended::Faults(self.faults()),
            Some(refused) => Ended::Refused(refused),
            None if self.is_stopped => Ended::Stopped,
            None => Ended::Done,
        })
    }

    fn command<P: Plant>(&mut self, sim: &SimulatedRig<'_, P>, stop: bool) -> Option<Command> {
        let state = sim.report().state;
        let is_ready = self.phase == Phase::PowerOn && state == State::Limp && sim.is_known();
        self.waits_for = sim.report().moving.filter(|_| is_ready);
        if stop && !self.is_stopped {
            (self.is_stopped, self.phase) = (true, Phase::Stopping);
            return Some(Command::Stop);
        }
        match (self.phase, state) {
            _ if is_ready && self.waits_for.is_none() => Some(Command::Arm),
            // What is missing is in the answer.
            (Phase::PowerOn, State::Limp | State::Off) if sim.time_s() >= READY_S => {
                Some(Command::Arm)
            }
            (Phase::PowerOn, State::Arming) => {
                self.phase = Phase::Arming;
                None
            }
            (Phase::Arming, State::Holding) => {
                self.phase = Phase::Playing;
                Some(Command::Play(Feed::Show))
            }
            // The show is over, or a fault holds it.
            (Phase::Playing, State::Holding) => {
                self.phase = Phase::Stopping;
                Some(Command::Stop)
            }
            (Phase::Playing | Phase::Arming, State::Stopping | State::Lowering | State::Limp) => {
                self.phase = Phase::Stopping;
                None
            }
            _ => None,
        }
    }
}
