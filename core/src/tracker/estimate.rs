//! The measured side: estimates, from the readings, the state at the time when the torques act.

use crate::control::Limited;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::observer::{Observer, ObserverError, ObserverSettings};
use crate::state::StateInputError;
use crate::transform::{Transform, Twist, Wrench};
use crate::tree::Tree;

use super::error::{InputError, check_count};
use super::frames::Measured;

/// The state of the rig: backward differences of readings, or an observer, which starts from these differences.
#[derive(Debug)]
pub(super) struct Estimate<const N: usize, const D: usize> {
    dt_s: f32,
    /// Last accepted reading, with measured speeds or speeds from differences.
    differenced: JointStates<N>,
    /// Ticks since the last accepted reading; zero before the first.
    age_ticks: u16,
    observer: Observer<N, D>,
    /// Whether the settings include an observer.
    observes: bool,
    /// Whether the observer is used, and has the last reading and the command that followed.
    observing: bool,
    cancel: bool,
}

impl<const N: usize, const D: usize> Estimate<N, D> {
    /// Creates an estimate for an empty tree, to be filled by [`init`](Self::init).
    pub(super) fn uninit() -> Self {
        Self {
            dt_s: 0.0,
            differenced: JointStates::uninit(),
            age_ticks: 0,
            observer: Observer::uninit(),
            observes: false,
            observing: false,
            cancel: false,
        }
    }

    /// Initializes in place for a rig, before any reading. On an error nothing changes.
    #[inline(never)]
    pub(super) fn init(
        &mut self,
        tree: &Tree<N>,
        dt_s: f32,
        settings: Option<ObserverSettings>,
        cancel: bool,
        latency_ticks: usize,
    ) -> Result<(), ObserverError> {
        let differenced = JointStates::rest(tree);
        if let Some(settings) = settings {
            self.observer.init(settings, &differenced, latency_ticks)?;
        }
        self.observes = settings.is_some();
        (self.dt_s, self.cancel) = (dt_s, cancel);
        self.differenced = differenced;
        (self.age_ticks, self.observing) = (0, false);
        Ok(())
    }

    /// Accepts a first reading, a tick before the next reading. If it has no speeds, the rig counts as at rest. All
    /// earlier estimates are forgotten.
    pub(super) fn begin(
        &mut self,
        tree: &Tree<N>,
        measured: Measured<'_>,
    ) -> Result<(), InputError> {
        self.age_ticks = 0;
        match measured {
            Measured::Poses(poses) => {
                check_count(tree.len(), poses.len())?;
                self.differenced.set_at_rest(poses)?;
            }
            Measured::Positions { q } => self.differenced.set_coordinates_at_rest(tree, q)?,
            Measured::Coordinates { q, qd } => self.differenced.set_coordinates(tree, q, qd)?,
        }
        self.age_ticks = 1;
        self.observing = false;
        if self.observes {
            self.observer.reset(&self.differenced);
        }
        Ok(())
    }

    /// Records that ticks were skipped: the next difference includes their time.
    pub(super) fn skip(&mut self, ticks: u16) {
        if self.age_ticks > 0 {
            self.age_ticks = self.age_ticks.saturating_add(ticks);
        }
    }

    /// Accepts the reading of a tick. If the first reading has no speeds, the rig counts as at rest, because its
    /// previous position is unknown.
    pub(super) fn observe(
        &mut self,
        tree: &Tree<N>,
        measured: Measured<'_>,
    ) -> Result<(), InputError> {
        let age_ticks = self.age_ticks;
        // The age grows before the reading is checked, because a refused reading also takes a tick.
        self.skip(1);
        match measured {
            Measured::Poses(poses) => {
                check_count(tree.len(), poses.len())?;
                self.observe_poses(tree, poses, age_ticks)?;
            }
            Measured::Positions { q } => self.observe_coordinates(tree, q, None, age_ticks)?,
            Measured::Coordinates { q, qd } => {
                self.observe_coordinates(tree, q, Some(qd), age_ticks)?;
            }
        }
        self.age_ticks = 1;
        Ok(())
    }

    /// Returns the time since a reading of that age, s.
    fn elapsed_s(&self, age_ticks: u16) -> f32 {
        self.dt_s * f32::from(age_ticks)
    }

    fn observe_poses(
        &mut self,
        tree: &Tree<N>,
        poses: &[Transform],
        age_ticks: u16,
    ) -> Result<(), StateInputError> {
        if self.observing && age_ticks == 1 {
            // Stored in case the next reading is refused. The observer has the speeds.
            self.differenced.set_at_rest(poses)?;
            return self.observer.observe_checked(tree, poses);
        }
        // The commands in a gap are unknown: after it the observer restarts from differences.
        match age_ticks {
            0 => self.differenced.set_at_rest(poses)?,
            _ => self.differenced.update_poses(poses, self.elapsed_s(age_ticks))?,
        }
        self.restart();
        Ok(())
    }

    // Never inlined: otherwise rigs without coordinates would pay for its stack frame.
    #[inline(never)]
    fn observe_coordinates(
        &mut self,
        tree: &Tree<N>,
        q: &[f32],
        qd: Option<&[f32]>,
        age_ticks: u16,
    ) -> Result<(), InputError> {
        let elapsed_s = self.elapsed_s(age_ticks);
        let observing = self.observing && age_ticks == 1;
        match (qd, age_ticks) {
            (Some(qd), _) => self.differenced.set_coordinates(tree, q, qd)?,
            (None, 0) => self.differenced.set_coordinates_at_rest(tree, q)?,
            // The observer has the speeds.
            (None, _) if observing => self.differenced.set_coordinates_at_rest(tree, q)?,
            (None, _) => self.differenced.update_coordinates(tree, q, elapsed_s)?,
        }
        if observing {
            let mut poses = [Transform::IDENTITY; N];
            for (pose, state) in poses.iter_mut().zip(self.differenced.as_slice()) {
                *pose = state.pose;
            }
            self.observer.observe(tree, poses.get(..tree.len()).unwrap_or_default())?;
        } else {
            self.restart();
        }
        Ok(())
    }

    /// Restarts the observer, if there is one, from the last reading.
    fn restart(&mut self) {
        if self.observes {
            self.observer.restart(&self.differenced);
            self.observing = true;
        }
    }

    /// Records that nothing was commanded in this tick, so that the observer restarts.
    pub(super) fn interrupt(&mut self) {
        self.observing = false;
    }

    /// Returns the estimated state at the time when the torques of this tick act.
    pub(super) fn states(&self) -> &JointStates<N> {
        if self.observes { self.observer.states() } else { &self.differenced }
    }

    /// Returns the observer, even if it is unused.
    pub(super) fn observer_mut(&mut self) -> &mut Observer<N, D> {
        &mut self.observer
    }

    /// Subtracts the learnt disturbances from the targets, if that is enabled.
    pub(super) fn compensate(&self, targets: &mut JointTargets<N>) {
        if self.observes && self.cancel {
            self.observer.compensate(targets);
        }
    }

    /// Records the commands to the joints.
    pub(super) fn commanded(&mut self, commands: &[Twist], torques: &[Limited<Wrench>]) {
        if self.observes {
            self.observer.record_commands(commands, torques);
        }
    }
}
