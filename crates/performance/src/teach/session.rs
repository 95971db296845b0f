//! Leads a simulated rig with a scripted hand.

use sinew_firmware::supervisor::{Command, FaultSet, Refused, State};
use sinew_rig::Mechanism;
use sinew_servo_sim::plant::RigPlant;
use thiserror::Error;

use super::{GuideTrajectory, ScriptedHand};
use crate::play::{Drive, RigParts, SimulatedRig};

/// Longest time until a rig must be ready, s.
const READY_S: f64 = 10.0;

/// State of the rig while it is led.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Torque is off.
    Limp,
    /// The rig carries its own weight.
    Float,
}

/// Error of a teaching session.
#[derive(Debug, Error)]
pub enum TeachSessionError {
    /// A servo cannot be commanded by effort.
    #[error(
        "the rig cannot carry itself: servo `{0}` is driven by position, and accepts no effort; lead it with torque \
         off (`--limp`)"
    )]
    NoEffort(String),
    /// A servo reports nothing.
    #[error(
        "nothing can be recorded by hand: servo `{0}` is driven by pulses, and does not report its position"
    )]
    TellsNothing(String),
    /// The controller refused a command.
    #[error("the controller refused: {0}")]
    Refused(Refused),
    /// Faults ended the session.
    #[error("it ended with {}: see docs/faults.md", names(*.0))]
    Faults(FaultSet),
    /// The rig did not reach the requested state.
    #[error("the rig is still {0} after 10 s")]
    NotReady(State),
}

fn names(faults: FaultSet) -> String {
    faults.iter().map(sinew_firmware::supervisor::Fault::name).collect::<Vec<_>>().join(", ")
}

/// The measured motion of a session.
#[derive(Debug, Clone)]
pub struct TeachRecording {
    /// Time between two rows, s.
    pub dt_s: f64,
    /// Measured coordinates while a hand led.
    pub rows: Vec<Vec<f64>>,
    /// Largest motion of each coordinate after the hand released the rig, rad or m.
    pub drift: Vec<f64>,
}

/// A simulated rig on its stand, and a hand.
pub struct TeachSession<'s, 'a> {
    sim: &'s mut SimulatedRig<'a, RigPlant>,
    hand: ScriptedHand,
}

/// Checks that the servos of a rig can be taught in a mode.
///
/// # Errors
/// [`TeachSessionError`] names the first servo that cannot.
pub fn check_servos(parts: &RigParts, mode: Mode) -> Result<(), TeachSessionError> {
    let name = |refused: fn(Drive) -> bool| {
        let found = parts.servos.iter().find(|part| refused(part.drive));
        found.map(|part| part.own.name.clone())
    };
    if let Some(name) = name(|drive| drive == Drive::Pulses) {
        return Err(TeachSessionError::TellsNothing(name));
    }
    match name(|drive| !drive.closes_loop()) {
        Some(name) if mode == Mode::Float => Err(TeachSessionError::NoEffort(name)),
        _ => Ok(()),
    }
}

impl<'s, 'a> TeachSession<'s, 'a> {
    /// Creates a session with a rig just before power-on.
    pub fn new(
        sim: &'s mut SimulatedRig<'a, RigPlant>,
        mechanism: &Mechanism,
        guide: GuideTrajectory,
    ) -> Self {
        Self { sim, hand: ScriptedHand::new(mechanism, guide) }
    }

    /// Runs the session. The hand holds the rig during power-on, leads it along the path, and releases it for
    /// `let_go_s`; then torque goes off. `each` receives the state of every tick.
    ///
    /// # Errors
    /// [`TeachSessionError`] if the rig cannot be taught, or a fault ends the session.
    pub fn run(
        &mut self,
        mode: Mode,
        let_go_s: f64,
        mut each: impl FnMut(f64, State),
    ) -> Result<TeachRecording, TeachSessionError> {
        check_servos(self.sim.parts, mode)?;
        let taught = if mode == Mode::Float { State::Floating } else { State::Teaching };
        self.hold(0.0);
        while self.sim.report().state != taught {
            let command = self.towards(mode);
            self.tick(command, &mut each)?;
            let state = self.sim.report().state;
            if state != taught && self.sim.time_s() > READY_S {
                return Err(TeachSessionError::NotReady(state));
            }
        }
        let begin_s = self.sim.time_s();
        let mut rows = Vec::new();
        loop {
            let time_s = self.sim.time_s() - begin_s;
            if time_s > self.hand.duration_s() {
                break;
            }
            self.hold(time_s);
            self.tick(None, &mut each)?;
            rows.push(self.sim.measured().iter().map(|x| f64::from(*x)).collect());
        }
        self.hand.let_go(|dof, hand| {
            self.sim.lead(dof, hand);
        });
        let (left, from_s) = (self.sim.q(), self.sim.time_s());
        let mut drift = vec![0.0; left.len()];
        while self.sim.time_s() < from_s + let_go_s {
            self.tick(None, &mut each)?;
            for ((most, at), left) in drift.iter_mut().zip(self.sim.q()).zip(&left) {
                *most = f64::max(*most, (at - left).abs());
            }
        }
        let mut command = Some(Command::Stop);
        while !matches!(self.sim.report().state, State::Limp | State::Faulted) {
            self.tick(command.take(), &mut each)?;
        }
        Ok(TeachRecording { dt_s: 1e-6 * f64::from(self.sim.parts.tick_us()), rows, drift })
    }

    /// Returns the next command on the way from the present state to the state for teaching. `None`: wait, or the state
    /// is reached.
    fn towards(&self, mode: Mode) -> Option<Command> {
        let report = self.sim.report();
        match (mode, report.state) {
            (Mode::Limp, State::Limp) => Some(Command::Teach),
            (Mode::Float, State::Limp) if self.sim.is_known() && report.moving.is_none() => {
                Some(Command::Arm)
            }
            (Mode::Float, State::Holding) => Some(Command::Float),
            _ => None,
        }
    }

    /// Moves the hand to its position at a time of the path.
    fn hold(&mut self, time_s: f64) {
        self.hand.hold(time_s, |dof, hand| {
            self.sim.lead(dof, hand);
        });
    }

    fn tick(
        &mut self,
        command: Option<Command>,
        each: &mut impl FnMut(f64, State),
    ) -> Result<(), TeachSessionError> {
        self.sim.tick(command);
        let report = self.sim.report();
        each(self.sim.time_s(), report.state);
        match report.answer {
            // The rig is not ready yet: for example, its registers are still being read.
            Some(Err(Refused::RegistersUnread | Refused::StopUntested | Refused::NotMeasured)) => {}
            Some(Err(why)) => return Err(TeachSessionError::Refused(why)),
            _ => {}
        }
        let raised = report.raised.minus(FaultSet::WARNINGS);
        if raised.is_empty() || !report.state.is_on() && report.state != State::Faulted {
            Ok(())
        } else {
            Err(TeachSessionError::Faults(raised))
        }
    }
}
