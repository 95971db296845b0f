//! The state that the controller goes by, from what the sensors tell.

use sinew_core::control::Limited;
use sinew_core::observer::{Observer, ObserverSettings};
use sinew_core::trajectory::backward_states;
use sinew_core::{JointStates, JointTargets, StateInputError, Transform, Tree, Twist, Wrench};

use super::controller::{MethodName, narrow};
use super::disturbance::LATENCY_MOST;
use super::error::RunError;
use super::setup::Setup;
use crate::figure::BODY_COUNT;

/// As many commands are on their way as the latency has steps, and one has just arrived.
type FigureObserver = Observer<BODY_COUNT, { LATENCY_MOST + 1 }>;

/// The state that the controller goes by: backward differences of the last two readings, or an observer's
/// that has begun with them.
pub(super) struct Estimate {
    before: [Transform; BODY_COUNT],
    dt_s: f32,
    states: JointStates<BODY_COUNT>,
    settings: Option<ObserverSettings>,
    delay: usize,
    cancel: bool,
    observer: Option<Box<FigureObserver>>,
}

impl Estimate {
    /// From the reading one step before the first.
    pub(super) fn new(
        setup: &Setup,
        tree: &Tree<BODY_COUNT>,
        before: &[Transform; BODY_COUNT],
        dt_s: f32,
    ) -> Result<Self, RunError> {
        let mut choice = setup.effective_controller().observer;
        if setup.controller.method == MethodName::Recommended {
            // As firmware does on slow rigs: an observer cannot be faster than its ticks.
            choice.bandwidth_rad_s = choice.bandwidth_rad_s.min(f64::from(1.0 / dt_s));
        }
        let settings = if choice.bandwidth_rad_s > 0.0 {
            Some(ObserverSettings::extended_state(narrow(choice.bandwidth_rad_s), dt_s)?)
        } else if choice.predict {
            Some(ObserverSettings::differences(dt_s)?)
        } else {
            None
        };
        Ok(Self {
            before: *before,
            dt_s,
            states: JointStates::rest(tree),
            settings,
            delay: if choice.predict { setup.disturbance.latency_steps } else { 0 },
            cancel: choice.cancel,
            observer: None,
        })
    }

    /// Takes in the reading of a step.
    pub(super) fn observe(
        &mut self,
        tree: &Tree<BODY_COUNT>,
        now: &[Transform; BODY_COUNT],
    ) -> Result<(), StateInputError> {
        if let Some(observer) = &mut self.observer {
            return observer.observe(tree, now);
        }
        backward_states([&self.before, now], self.dt_s, &mut self.states)?;
        self.before = *now;
        if let Some(settings) = self.settings {
            let observer = Observer::new(settings, &self.states, self.delay);
            self.observer = observer.ok().map(Box::new);
        }
        Ok(())
    }

    /// The state that a command of this step will meet, as far as it is known.
    pub(super) fn states(&self) -> &JointStates<BODY_COUNT> {
        self.observer.as_ref().map_or(&self.states, |observer| observer.states())
    }

    /// Takes off the targets what the observer has learnt of disturbances, if it is to.
    pub(super) fn compensate(&self, targets: &mut JointTargets<BODY_COUNT>) {
        if let Some(observer) = self.observer.as_ref().filter(|_| self.cancel) {
            observer.compensate(targets);
        }
    }

    /// Notes what the joints were commanded.
    pub(super) fn sent(&mut self, commands: &[Twist], torques: &[Limited<Wrench>]) {
        if let Some(observer) = &mut self.observer {
            observer.record_commands(commands, torques);
        }
    }
}
