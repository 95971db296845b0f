//! Commands of a performance, and its end.

use sinew_firmware::supervisor::{Command, FaultSet, Feed, Moving, Refused, State};
use sinew_servo_sim::load::Plant;

use super::simulated_rig::SimulatedRig;

/// Longest time after power-on until the rig must be ready, s.
const READY_S: f64 = 5.0;

/// The end of a performance.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ended {
    /// The show ended, and the rig is limp.
    Done,
    /// A person stopped the show, and the rig is limp.
    Stopped,
    /// These faults ended the performance; torque is off.
    Faults(FaultSet),
    /// The controller refused a command.
    Refused(Refused),
    /// The preroll is shorter than the way to the first pose, which takes this time, ms; the rig is limp.
    Preroll(u32),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    PowerOn,
    Arming,
    Playing,
    Stopping,
}

/// Arms a rig, plays its show, and stops it.
#[derive(Debug)]
pub struct Director {
    phase: Phase,
    raised: FaultSet,
    refused: Option<Refused>,
    is_stopped: bool,
    /// Whether the next tick gets an emergency stop.
    is_cut: bool,
    /// The joint that must come to rest before the rig is armed, or `None`.
    waits_for: Option<Moving>,
    /// Time from arming to the start of the show's clock, s. `None`: the clock starts when the rig reaches the first
    /// pose.
    preroll_s: Option<f64>,
    /// Planned time of the command to play, s; `None` before the rig is armed.
    play_at_s: Option<f64>,
    /// Duration of the way to the first pose, ms, if it is longer than the preroll.
    needed_ms: Option<u32>,
}

impl Default for Director {
    fn default() -> Self {
        let (refused, waits_for) = (None, None);
        let (phase, raised) = (Phase::PowerOn, FaultSet::EMPTY);
        let (preroll_s, play_at_s, needed_ms) = (None, None, None);
        Self {
            phase,
            raised,
            refused,
            is_stopped: false,
            is_cut: false,
            waits_for,
            preroll_s,
            play_at_s,
            needed_ms,
        }
    }
}

impl Director {
    /// Creates a director with a preroll: time from arming to the start of the show's clock, s. With `None`, the clock
    /// starts when the rig reaches the first pose.
    pub fn with_preroll(preroll_s: Option<f64>) -> Self {
        Self { preroll_s, ..Self::default() }
    }

    /// Returns all faults and warnings of the performance.
    pub fn raised(&self) -> FaultSet {
        self.raised
    }

    /// Returns the faults that end a performance.
    fn faults(&self) -> FaultSet {
        self.raised.minus(FaultSet::WARNINGS)
    }

    /// Returns the joint that must come to rest before the rig is armed; `None` if the rig need not wait.
    pub fn waits_for(&self) -> Option<Moving> {
        self.waits_for
    }

    /// Switches torque off in the next tick.
    pub fn cut(&mut self) {
        self.is_cut = true;
    }

    /// Runs a tick of the simulated rig. `stop`: a person asks for a stop. Returns `None` until torque is off for good;
    /// then returns the end of the performance.
    pub fn tick<P: Plant>(&mut self, sim: &mut SimulatedRig<'_, P>, stop: bool) -> Option<Ended> {
        let is_cut = std::mem::take(&mut self.is_cut);
        let command = if is_cut { Some(Command::EStop) } else { self.command(sim, stop) };
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
            None if self.needed_ms.is_some() => Ended::Preroll(self.needed_ms.unwrap_or_default()),
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
            // A refusal names what is missing.
            (Phase::PowerOn, State::Limp | State::Off) if sim.time_s() >= READY_S => {
                Some(Command::Arm)
            }
            (Phase::PowerOn, State::Arming) => {
                self.phase = Phase::Arming;
                None
            }
            (Phase::Arming, State::Holding) => self.play(sim),
            // The show has ended, or a fault makes the rig hold.
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

    /// Returns the command to play when its time has come, so that the way to the first pose ends together with the
    /// preroll. Returns a stop if the preroll is too short.
    fn play<P: Plant>(&mut self, sim: &SimulatedRig<'_, P>) -> Option<Command> {
        let at_s = match (self.play_at_s, self.preroll_s) {
            (Some(at_s), _) => at_s,
            (None, None) => sim.time_s(),
            (None, Some(preroll_s)) => {
                let way_s = sim.approach().map_or(0.0, |approach| f64::from(approach.way_s));
                if way_s > preroll_s {
                    #[expect(
                        clippy::cast_possible_truncation,
                        clippy::cast_sign_loss,
                        reason = "at most 300 s"
                    )]
                    let needed_ms = (1e3 * way_s).ceil() as u32;
                    (self.needed_ms, self.phase) = (Some(needed_ms), Phase::Stopping);
                    return Some(Command::Stop);
                }
                sim.time_s() + preroll_s - way_s
            }
        };
        self.play_at_s = Some(at_s);
        if sim.time_s() < at_s {
            return None;
        }
        self.phase = Phase::Playing;
        Some(Command::Play(Feed::Show))
    }
}
