//! A simulated rig that a scripted hand leads.

use sinew_firmware::supervisor::{Command, FaultSet, Refused, State};
use sinew_rig::Mechanism;
use sinew_servo_sim::plant::RigPlant;
use thiserror::Error;

use super::{GuideTrajectory, ScriptedHand};
use crate::play::{Drive, RigParts, SimulatedRig};

/// After so long a rig that is not ready will not be, s.
const READY_S: f64 = 10.0;

/// How the rig is while it is led.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Torque is off.
    Limp,
    /// It carries its own weight.
    Float,
}

/// Why nothing was taught.
#[derive(Debug, Error)]
pub enum TeachSessionError {
    /// Servos that take no effort.
    #[error(
        "the rig cannot carry itself: servo `{0}` is driven by position, and takes no effort; teach it limp (`--limp`)"
    )]
    NoEffort(String),
    /// Servos that tell nothing.
    #[error(
        "nothing can be taught by hand: servo `{0}` takes pulses, and does not tell where it is"
    )]
    TellsNothing(String),
    /// A command was refused.
    #[error("the controller refused: {0}")]
    Refused(Refused),
    /// Faults ended it.
    #[error("it ended with {}: see docs/faults.md", names(*.0))]
    Faults(FaultSet),
    /// It did not become what it was asked to be.
    #[error("the rig is still {0} after 10 s")]
    NotReady(State),
}

fn names(faults: FaultSet) -> String {
    faults.iter().map(sinew_firmware::supervisor::Fault::name).collect::<Vec<_>>().join(", ")
}

/// What was measured.
#[derive(Debug, Clone)]
pub struct TeachRecording {
    /// From row to row, s.
    pub dt_s: f64,
    /// Measured coordinates while a hand led.
    pub rows: Vec<Vec<f64>>,
    /// How far each coordinate went after the hand let go, rad or m: the most in all that time.
    pub drift: Vec<f64>,
}

/// A rig on its stand, and a hand.
pub struct TeachSession<'s, 'a> {
    sim: &'s mut SimulatedRig<'a, RigPlant>,
    hand: ScriptedHand,
}

/// That the servos of a rig can be taught so.
///
/// # Errors
/// [`TeachSessionError`] names the first one that cannot.
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
    /// With a stand just before power comes on.
    pub fn new(
        sim: &'s mut SimulatedRig<'a, RigPlant>,
        mechanism: &Mechanism,
        guide: GuideTrajectory,
    ) -> Self {
        Self { sim, hand: ScriptedHand::new(mechanism, guide) }
    }

    /// Power on, the hand holds the rig; it is led along a way, let go for `let_go_s`, and made limp. `each` sees every
    /// tick's state.
    ///
    /// # Errors
    /// [`TeachSessionError`].
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

    /// What leads from the present state to the one in which it is taught.
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

    /// Where the hand is now.
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
            // Registers are still being read.
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
