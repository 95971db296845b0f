//! Converts frames and readings to torques in one call: the complete pipeline, identical on boards and in simulators.
//!
//! ```text
//! frames ── (manifold projection) ── differences ───────┐
//!                                                       ├── TorqueController ── (supply) ──> torques
//! readings ── backward differences, or an observer ─────┘                    │
//!                          ▲                                                 │
//!                          └──────────────── commanded accelerations ────────┘
//! ```

mod desired;
mod error;
mod estimate;
mod frames;
mod names;
mod rest;
mod settings;
mod timing;

use crate::body_weight::BodyWeight;
use crate::control::{Limited, TorqueLimit};
use crate::controller::{ControllerError, TorqueController, Workspace};
use crate::coordinates::{CoordinatesError, DofCommand};
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::observer::Stance;
use crate::projection::JointRange;
use crate::state_error::StateError;
use crate::supply::TorqueSupply;
use crate::transform::Wrench;
use crate::tree::Tree;

use desired::Desired;
use estimate::Estimate;
use rest::Rest;

pub use error::{InputError, SettingError, StepError, TrackerError};
pub use frames::{Frame, FrameSource, Measured, extrapolate_before_start};
pub use names::{
    AimName, DesiredVelocity, Differences, GainsName, MethodName, Sharing, WeightsName,
};
pub use rest::STANDS_RAD_S;
pub use settings::{
    BANDWIDTH_RAD_S, ObserverChoice, ProjectionSettings, RECOMMENDED_ROTATION_WEIGHT_M,
    ResolvedSettings, Settings,
};
pub use timing::{MAX_DELAY_S, Timing};

/// A [`Tracker`] of a rig of up to `N` bodies, for a latency of up to 7 ticks and all methods except resolved
/// acceleration.
///
/// ```
/// use sinew_core::tracker::{RigTracker, Settings, Timing};
/// use sinew_core::{Body, Inertia, Tree, glam::Vec3};
/// let link = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
/// let head = Tree::<1>::from_bodies(&[Body::revolute(None, Vec3::X, Vec3::ZERO, link)])?;
/// let timing = Timing { dt_s: 0.002, latency_ticks: 1 };
/// let tracker = RigTracker::new(head, &Settings::default(), timing)?;
/// assert_eq!(tracker.controller().tree().len(), 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type RigTracker<const N: usize> = Tracker<N, 8>;

/// A [`Tracker`] with room for resolved acceleration, 132 bytes for each body of the capacity `N`, and for latencies of
/// up to `D` - 1 ticks. [`Tracker::with_workspace`] creates it with [`Workspace::resolving`].
pub type ResolvedTracker<const N: usize, const D: usize = 8> = Tracker<N, D, N>;

/// A tracker, with which a rig of up to `N` bodies follows a performance: frames and readings in, limited torques out,
/// one call per tick.
///
/// Most programs need [`RigTracker`], which has no parameter but `N`. `D`: maximum latency in ticks, plus one. `R`: `N`
/// for resolved acceleration, else 0. The value contains all its memory: store it in a static.
///
/// ```
/// use sinew_core::tracker::{Frame, FrameSource, RigTracker, Settings, Timing};
/// use sinew_core::{Body, Inertia, JointKind, RotationalInertia, Transform, Tree};
/// use sinew_core::{glam::Vec3, math};
/// let head = Body {
///     parent: None,
///     joint: JointKind::Revolute { axis: Vec3::Y },
///     placement: Transform::IDENTITY,
///     inertia: Inertia {
///         mass_kg: 0.4,
///         center_of_mass_m: Vec3::Y * 0.1,
///         rotational_kg_m2: RotationalInertia::diagonal(1e-3, 1e-3, 1e-3),
///     },
///     rotor_inertia: 0.0,
/// };
/// /// A head that shakes.
/// struct Shake([Transform; 1]);
///
/// impl FrameSource for Shake {
///     fn frame(&mut self, index: i32) -> Frame<'_> {
///         let angle_rad = 0.5 * (0.02 * index as f32).sin();
///         self.0 = [Transform::new(math::exp(Vec3::Y * angle_rad), Vec3::ZERO)];
///         Frame::Poses(&self.0)
///     }
/// }
///
/// let timing = Timing { dt_s: 0.002, latency_ticks: 1 };
/// let tree = Tree::<1>::from_bodies(&[head])?;
/// let mut tracker = RigTracker::new(tree, &Settings::recommended(), timing)?;
/// let mut show = Shake([Transform::IDENTITY]);
/// for tick in 0..100 {
///     // Input: readings of the joints' sensors. Output: torques for their drives.
///     let measured = [Transform::IDENTITY];
///     let mut efforts_nm = [0.0];
///     tracker.step(&mut show, tick, &measured)?.efforts(&mut efforts_nm)?;
///     // To the servo.
///     assert!(efforts_nm[0].is_finite());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Tracker<const N: usize, const D: usize = 1, const R: usize = 0> {
    controller: TorqueController<N>,
    desired: Desired<N>,
    estimate: Estimate<N, D>,
    rest: Rest<N>,
    supply: Option<TorqueSupply<N>>,
    sharing: Sharing,
    workspace: Workspace<N, R>,
}

impl<const N: usize, const D: usize> Tracker<N, D> {
    /// Creates a tracker of a rig, for all methods except resolved acceleration. O(n).
    ///
    /// # Errors
    /// [`TrackerError`] if a setting or the timing is invalid, or invalid for this rig. With an observer that predicts,
    /// also if the latency is more than `D - 1` ticks.
    pub fn new(tree: Tree<N>, settings: &Settings, timing: Timing) -> Result<Self, TrackerError> {
        Self::with_workspace(tree, settings, timing, Workspace::new())
    }
}

impl<const N: usize, const D: usize, const R: usize> Tracker<N, D, R> {
    /// Creates a tracker with a workspace: resolved acceleration needs [`Workspace::resolving`].
    ///
    /// # Errors
    /// As in [`Tracker::new`].
    #[expect(clippy::needless_pass_by_value, reason = "a tracker has its own rig and workspace")]
    pub fn with_workspace(
        tree: Tree<N>,
        settings: &Settings,
        timing: Timing,
        workspace: Workspace<N, R>,
    ) -> Result<Self, TrackerError> {
        let mut tracker = Self { workspace, ..Self::uninit() };
        tracker.init(&tree, settings, timing)?;
        Ok(tracker)
    }

    /// Creates a tracker of an empty tree, to be filled in place by [`init`](Self::init). The value is large, and
    /// each move would cost its size in stack.
    #[inline(never)]
    pub fn uninit() -> Self {
        Self {
            controller: TorqueController::uninit(),
            desired: Desired::uninit(),
            estimate: Estimate::uninit(),
            rest: Rest::uninit(),
            supply: None,
            sharing: Sharing::Uniform,
            workspace: Workspace::with_room(),
        }
    }

    /// Initializes in place, with the result of [`Tracker::new`].
    ///
    /// # Errors
    /// As in [`Tracker::new`]. After an error the tracker must be initialized again.
    #[inline(never)]
    pub fn init(
        &mut self,
        tree: &Tree<N>,
        settings: &Settings,
        timing: Timing,
    ) -> Result<(), TrackerError> {
        self.init_for_coordinates(tree, settings, timing)?;
        let projection = settings.effective(timing.dt_s).projection(tree)?;
        self.desired.set_projection(projection);
        Ok(())
    }

    /// Initializes in place for frames of the rig's own coordinates only. They need no projection, so an image
    /// without poses contains none.
    ///
    /// # Errors
    /// As in [`Tracker::new`]. After an error the tracker must be initialized again.
    #[inline(never)]
    pub fn init_for_coordinates(
        &mut self,
        tree: &Tree<N>,
        settings: &Settings,
        timing: Timing,
    ) -> Result<(), TrackerError> {
        let Timing { dt_s, latency_ticks } = timing;
        timing.check()?;
        if settings.method == MethodName::Recommended {
            timing.check_recommended()?;
        }
        settings.set_controller(&mut self.controller, tree, dt_s)?;
        let effective = settings.effective(dt_s);
        // Without prediction, the tracker acts as if there were no latency.
        let latency_ticks = if effective.observer.predict { latency_ticks } else { 0 };
        let ahead = i32::try_from(latency_ticks).unwrap_or(i32::MAX);
        let differences = (effective.differences, effective.desired_velocity);
        let (observer, cancel) = (effective.observer(dt_s)?, effective.observer.cancel);
        self.estimate.init(tree, dt_s, observer, cancel, latency_ticks)?;
        self.desired.init(tree, dt_s, ahead, differences);
        self.rest.init(dt_s);
        (self.supply, self.sharing) = (None, effective.sharing);
        Ok(())
    }

    /// Sets the observer's bandwidth for each joint, rad/s; 0 selects the settings' bandwidth. See
    /// [`Bandwidth`](crate::bandwidth::Bandwidth). O(n).
    ///
    /// # Errors
    /// [`TrackerError::Observer`], and nothing changes, if the settings have no observer, or in the cases of
    /// [`Observer::set_bandwidths`](crate::observer::Observer::set_bandwidths).
    pub fn set_bandwidths(&mut self, rad_s: &[f32]) -> Result<(), TrackerError> {
        Ok(self.estimate.observer_mut().set_bandwidths(rad_s)?)
    }

    /// Sets the radius of the rest zone of each joint, rad (for slides, m); 0 for no zone. O(n).
    ///
    /// While a joint's target is slower than [`STANDS_RAD_S`] and the joint itself slower than ten times this speed, an
    /// error within the zone counts as zero, and the observer learns nothing from it. A suitable radius is half the
    /// play of the joint's gear plus a step of its encoder: within it, the loop can only hunt.
    ///
    /// A joint stands when it has been within four radii of a constant target for 0.3 s. It then learns nothing
    /// within one and a half radii. If it has its own bandwidth ([`Self::set_bandwidths`]), it uses 0.6 of it while
    /// it stands: within the play of a gear, a loop with the full bandwidth can swing, and there is no motion to
    /// follow.
    ///
    /// # Errors
    /// [`TrackerError::Rest`], and nothing changes, if the number of radii is not the number of joints, or a radius
    /// is not a finite number, zero or more.
    pub fn set_rest(&mut self, radii: &[f32]) -> Result<(), TrackerError> {
        let fits = radii.len() == self.controller.tree().len();
        // Written so that NaN fails.
        if !fits || !radii.iter().all(|radius| *radius >= 0.0 && radius.is_finite()) {
            return Err(TrackerError::Rest);
        }
        self.rest.set(radii);
        Ok(())
    }

    /// Sets a torque limit for each joint.
    ///
    /// # Errors
    /// [`ControllerError`] in the cases of [`TorqueController::with_limits`].
    pub fn with_limits(self, limits: &[TorqueLimit]) -> Result<Self, ControllerError> {
        Ok(Self { controller: self.controller.with_limits(limits)?, ..self })
    }

    /// Sets gravity, in world axes, m/s². Default: 9.81 m/s² along -y.
    ///
    /// # Errors
    /// [`ControllerError`] in the cases of [`TorqueController::with_gravity`].
    pub fn with_gravity(self, gravity_m_s2: glam::Vec3) -> Result<Self, ControllerError> {
        Ok(Self { controller: self.controller.with_gravity(gravity_m_s2)?, ..self })
    }

    /// Sets the supply that all drives share, by the rule of [`Settings::sharing`].
    ///
    /// # Errors
    /// [`TrackerError`] if the supply is for another number of joints, has weights although the rule is not
    /// [`Sharing::Importance`], or has no weights although the rule is [`Sharing::Importance`].
    pub fn with_supply(self, supply: TorqueSupply<N>) -> Result<Self, TrackerError> {
        let (expected, found) = (self.controller.tree().len(), supply.joint_count());
        if found != expected {
            return Err(TrackerError::SupplyJoints { expected, found });
        }
        if supply.has_weights() != (self.sharing == Sharing::Importance) {
            return Err(TrackerError::SupplyWeights);
        }
        Ok(Self { supply: Some(supply), ..self })
    }

    /// Sets a range for each joint: the projection gives no target outside these ranges.
    ///
    /// # Errors
    /// [`TrackerError`] if the method has no projection, the number of ranges is not the number of joints, or a range
    /// does not fit its joint.
    pub fn with_ranges(mut self, ranges: &[JointRange]) -> Result<Self, TrackerError> {
        let tree = self.controller.tree();
        self.desired
            .replace_projection(|projection| projection.clone().with_ranges(tree, ranges))?;
        Ok(self)
    }

    /// Sets the weights of the projection, such as
    /// [`BodyWeights::by_importance`](crate::projection::BodyWeights::by_importance).
    ///
    /// # Errors
    /// [`TrackerError`] if the method has no projection, or the weights do not fit the rig.
    pub fn with_weights(mut self, weights: &[BodyWeight]) -> Result<Self, TrackerError> {
        let tree = self.controller.tree();
        self.desired
            .replace_projection(|projection| projection.clone().with_weights(tree, weights))?;
        Ok(self)
    }

    /// Starts like a new tracker at tick `index`: reads the frames before those of the tick, and accepts a reading
    /// from a tick earlier. If the reading has no speeds, the rig counts as at rest.
    ///
    /// The call may be left out: the first [`Self::step`] then reads the earlier frames itself, and starts from its own
    /// reading. If the projection must find its first pose, the call takes as long as about twenty ticks.
    ///
    /// # Errors
    /// [`StepError`] if a frame or the reading is refused. Call the function again.
    pub fn begin<'m>(
        &mut self,
        frames: &mut impl FrameSource,
        index: i32,
        measured: impl Into<Measured<'m>>,
    ) -> Result<(), StepError> {
        let tree = self.controller.tree();
        self.desired.begin(tree, frames, index).map_err(StepError::Frame)?;
        self.rest.begin();
        self.estimate.begin(tree, measured.into()).map_err(StepError::Measured)
    }

    /// Starts another performance at tick `index` while the rig moves: reads the frames before those of the tick, and
    /// keeps the estimated state of the rig. The new source may be of another kind.
    ///
    /// The call takes as long as [`Self::begin`]. If ticks are missed meanwhile, call [`Self::skip`]. Targets jump to
    /// the new performance; to avoid a jump, the source must blend.
    ///
    /// # Errors
    /// [`StepError::Frame`] if a frame is refused. Call the function again.
    pub fn begin_frames(
        &mut self,
        frames: &mut impl FrameSource,
        index: i32,
    ) -> Result<(), StepError> {
        self.desired.begin(self.controller.tree(), frames, index).map_err(StepError::Frame)
    }

    /// Records that `ticks` were missed since the last call of [`Self::begin`] or [`Self::step`]. The next velocities
    /// are then differences over the elapsed time, and an observer, which does not know the commands in between,
    /// restarts from these velocities. A refused call of [`Self::step`] does not count as missed.
    pub fn skip(&mut self, ticks: u16) {
        self.estimate.skip(ticks);
    }

    /// Computes the torques of a tick for frame `index`, from the present measurement of the joints' sensors. O(n).
    ///
    /// Each tick reads one frame. A target needs several consecutive frames of poses. In the first three ticks after
    /// a jump (a missed tick or a refused frame), the targets therefore continue at constant velocities. A tick after
    /// a jump thus takes no longer than others. To use the new frames at once, call [`Self::begin_frames`].
    ///
    /// The time of a refused tick counts: the next tick computes differences over it. For missed ticks, call
    /// [`Self::skip`].
    ///
    /// # Errors
    /// [`StepError`] if a frame or the reading is refused: the number of poses or coordinates does not fit the rig, a
    /// number is not finite or too large, a rotation is not unit, or the frame is of another kind than the first
    /// frames. There are then no torques, and the servos must be kept in a safe state.
    pub fn step<'m>(
        &mut self,
        frames: &mut impl FrameSource,
        index: i32,
        measured: impl Into<Measured<'m>>,
    ) -> Result<Tick<'_, N, D, R>, StepError> {
        let tree = self.controller.tree();
        let of_frame = self.desired.follow(tree, frames, index);
        // The reading is stored even if the frame was refused.
        self.estimate.observe(tree, measured.into()).map_err(StepError::Measured)?;
        if let Err(error) = of_frame {
            self.estimate.interrupt();
            return Err(StepError::Frame(error));
        }
        let (targets, w) = (self.desired.targets_mut(), &mut self.workspace);
        self.rest.apply(tree, self.controller.gains(), targets, self.estimate.states());
        self.estimate.compensate(targets);
        let states = self.estimate.states();
        self.controller.tick(targets, states, &[], w);
        let count = tree.len();
        if let Some(supply) = &self.supply {
            share(&self.controller, supply, self.sharing, states, w);
        }
        let torques = w.torques().get(..count).unwrap_or_default();
        self.estimate.commanded(w.commands(), torques);
        for (joint, stance) in self.rest.stances().iter().enumerate().take(count) {
            if *stance != Stance::Moves {
                self.estimate.observer_mut().note_stance(joint, *stance);
            }
        }
        Ok(Tick { tracker: self })
    }

    /// Records that a dof swings. The measurement that shows the effect of the last tick's command is observed with
    /// this share, 0 to 1, of the joint's own bandwidth. O(n).
    ///
    /// The observer is part of the loop that sustains a swing through a soft gear. Less feedback alone would not
    /// stop the swing.
    pub fn note_swing(&mut self, dof: usize, share: f32) {
        if let Some(joint) = self.joint_of(dof) {
            self.estimate.observer_mut().note_share(joint, share);
        }
    }

    /// Records that the drive of a dof could not deliver the command of the last tick. From the measurement that
    /// shows this command's effect, no disturbance is learnt that would ask for more torque. O(n).
    pub fn note_limited(&mut self, dof: usize) {
        let Some(joint) = self.joint_of(dof) else { return };
        let bodies = self.controller.tree().bodies();
        if let (Some(body), Some(torque)) = (bodies.get(joint), self.workspace.torques().get(joint))
        {
            self.estimate.observer_mut().note_limited(joint, body, &torque.value);
        }
    }

    /// Returns the joint that a dof belongs to.
    fn joint_of(&self, dof: usize) -> Option<usize> {
        let mut first = dof;
        self.controller.tree().bodies().iter().position(|body| {
            let count = body.joint.dof_count();
            let has_it = first < count;
            first = first.saturating_sub(count);
            has_it
        })
    }

    /// Returns the rig's controller.
    pub fn controller(&self) -> &TorqueController<N> {
        &self.controller
    }

    /// Returns the targets of the last tick.
    pub fn targets(&self) -> &JointTargets<N> {
        self.desired.targets()
    }

    /// Returns the state that the last tick used: as measured, or, with an observer, predicted for the time when the
    /// torques act.
    pub fn states(&self) -> &JointStates<N> {
        self.estimate.states()
    }

    /// Returns the workspace with the results of the last tick: commands and torques.
    pub fn workspace(&self) -> &Workspace<N, R> {
        &self.workspace
    }

    /// Writes the state errors of the last tick, see [`TorqueController::errors`].
    pub fn errors(&mut self, out: &mut [StateError]) {
        let states = self.estimate.states();
        self.controller.errors(self.desired.targets_mut(), states, &mut self.workspace, out);
    }
}

/// The result of a tick. A refused tick has none.
#[derive(Debug)]
pub struct Tick<'t, const N: usize, const D: usize = 1, const R: usize = 0> {
    tracker: &'t mut Tracker<N, D, R>,
}

impl<const N: usize, const D: usize, const R: usize> Tick<'_, N, D, R> {
    /// Returns the wrench of each joint's drive, as in [`TorqueController::tick`].
    pub fn torques(&self) -> &[Limited<Wrench>] {
        let count = self.tracker.controller.tree().len();
        self.tracker.workspace.torques().get(..count).unwrap_or_default()
    }

    /// Writes the efforts that the drives must deliver, by dof, N m or N: see [`Tree::efforts`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`] if the length of `out` is not the number of dofs.
    pub fn efforts(&self, out: &mut [f32]) -> Result<(), CoordinatesError> {
        let states = self.tracker.estimate.states().as_slice();
        self.tracker.controller.tree().efforts(states, self.torques(), out)
    }

    /// Writes the command for each dof: target, feed-forward and feedback effort, and the reason of a limit. See
    /// [`TorqueController::dof_commands`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`] if the length of `out` is not the number of dofs.
    pub fn dof_commands(&mut self, out: &mut [DofCommand]) -> Result<(), CoordinatesError> {
        let Tracker { controller, desired, estimate, workspace, .. } = &mut *self.tracker;
        controller.dof_commands(desired.targets(), estimate.states(), &[], workspace, out)
    }
}

/// Reduces the torques of the last tick to the supply.
// Never inlined into the tick: otherwise every rig would pay for its stack frame.
#[inline(never)]
fn share<const N: usize, const R: usize>(
    controller: &TorqueController<N>,
    supply: &TorqueSupply<N>,
    sharing: Sharing,
    states: &JointStates<N>,
    w: &mut Workspace<N, R>,
) {
    let count = controller.tree().len();
    if sharing == Sharing::Accelerations && supply.supply_nm().is_finite() {
        let mut carried = [Wrench::ZERO; N];
        controller.bias_wrenches(states, &[], w, &mut carried);
        supply.share_acceleration(w.torques_mut().get_mut(..count).unwrap_or_default(), &carried);
    } else {
        supply.share(w.torques_mut().get_mut(..count).unwrap_or_default());
    }
}
