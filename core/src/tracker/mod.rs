//! From frames and readings to torques in one call: the whole composition, the same on boards and in simulators.
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

/// Tracks a performance with a rig of up to `N` bodies: frames and readings in, limited torques out, one call a tick.
///
/// `D`: one more than the longest latency in ticks. `R`: `N` for resolved acceleration, else 0. All memory is in here:
/// put it in a static.
///
/// ```
/// use sinew_core::tracker::{Frame, FrameSource, Settings, Timing, Tracker};
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
/// let mut tracker = Tracker::<1, 8>::new(tree, &Settings::recommended(), timing)?;
/// let mut show = Shake([Transform::IDENTITY]);
/// for tick in 0..100 {
///     // What the sensors of the joints say goes in, and torques for their drives come out.
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
    /// A tracker of a rig, for all methods but resolved acceleration. O(n).
    ///
    /// # Errors
    /// [`TrackerError`] if a setting or the timing cannot be, not on this rig, or the latency is longer than `D` - 1.
    pub fn new(tree: Tree<N>, settings: &Settings, timing: Timing) -> Result<Self, TrackerError> {
        Self::with_workspace(tree, settings, timing, Workspace::new())
    }
}

impl<const N: usize, const D: usize, const R: usize> Tracker<N, D, R> {
    /// Creates a tracker with a workspace: resolved acceleration needs [`Workspace::resolving`].
    ///
    /// # Errors
    /// As [`Tracker::new`].
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

    /// Creates a tracker of no bodies, which asks for nothing, for [`init`](Self::init) to fill in place. The value is
    /// large: each move would take its size of stack.
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

    /// Initializes in place: the result is that of [`Tracker::new`].
    ///
    /// # Errors
    /// As [`Tracker::new`]: it must be initialized again then.
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

    /// Initializes in place for frames of the rig's own coordinates alone: they need no projection, so an image without
    /// poses has none.
    ///
    /// # Errors
    /// As [`Tracker::new`]: it must be initialized again then.
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
        // Who does not look ahead acts as if there were no latency.
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

    /// Sets the observer's bandwidth of each joint, rad/s; 0 for that of the settings. See
    /// [`Bandwidth`](crate::bandwidth::Bandwidth). O(n).
    ///
    /// # Errors
    /// [`TrackerError::Observer`], and nothing is changed. [`Observer`](crate::observer::Observer) names the limits.
    pub fn set_bandwidths(&mut self, rad_s: &[f32]) -> Result<(), TrackerError> {
        Ok(self.estimate.observer_mut().set_bandwidths(rad_s)?)
    }

    /// Sets the rest zone of each joint: while its target is slower than [`STANDS_RAD_S`], an error of at most so many
    /// rad (of slides, m) counts as none, and the observer learns nothing from it. 0 for none. Half the play of a
    /// joint's gear and a step of its encoder is the radius within which its loop can only hunt. A joint with a zone
    /// and a bandwidth of its own ([`Self::set_bandwidths`]) has 0.6 of it while it stands: within the play of a gear
    /// a loop of the whole bandwidth can swing, and nothing is to be followed. It stands when it has been within four
    /// radii of a target that stands for 0.3 s, and then learns nothing within one and a half radii. O(n).
    ///
    /// # Errors
    /// [`TrackerError::Rest`], and nothing is changed, if there is not one for each joint, or one is not a finite
    /// number from 0.
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
    /// [`ControllerError`] as [`TorqueController::with_limits`].
    pub fn with_limits(self, limits: &[TorqueLimit]) -> Result<Self, ControllerError> {
        Ok(Self { controller: self.controller.with_limits(limits)?, ..self })
    }

    /// Sets gravity, in world axes, m/s². Default: 9.81 m/s² along -y.
    ///
    /// # Errors
    /// [`ControllerError`] as [`TorqueController::with_gravity`].
    pub fn with_gravity(self, gravity_m_s2: glam::Vec3) -> Result<Self, ControllerError> {
        Ok(Self { controller: self.controller.with_gravity(gravity_m_s2)?, ..self })
    }

    /// Sets the supply that all drives share, by the rule of [`Settings::sharing`].
    ///
    /// # Errors
    /// [`TrackerError`] if the supply is of another number of joints, or has weights where
    /// [`Sharing::Importance`] is not the rule, or has none where it is.
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

    /// Sets a range for each joint: the projection has no target outside of them.
    ///
    /// # Errors
    /// [`TrackerError`] if the method has no projection, there is not a range for each joint, or one does not fit its
    /// joint.
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
    /// [`TrackerError`] if the method has no projection, or the weights are not the rig's.
    pub fn with_weights(mut self, weights: &[BodyWeight]) -> Result<Self, TrackerError> {
        let tree = self.controller.tree();
        self.desired
            .replace_projection(|projection| projection.clone().with_weights(tree, weights))?;
        Ok(self)
    }

    /// Begins as a new tracker would, with tick `index`: takes the frames that lead to those of the tick, and a
    /// reading of one tick before it. If the reading has no speeds, it counts as that of a rig at rest.
    ///
    /// The first tick of all does this itself, from its own reading. It takes as long as some twenty ticks where the
    /// projection has to find its first pose.
    ///
    /// # Errors
    /// [`StepError`] if a frame or the reading is refused: begin again.
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

    /// Begins another performance with tick `index` while the rig moves: takes the frames that lead to those of the
    /// tick, and leaves what is known of the rig. The source may be of another kind than the one before.
    ///
    /// It takes as long as [`Self::begin`]. If ticks are left out meanwhile, [`Self::skip`] them. Targets jump to the
    /// new performance: where they must not, let the source lead over.
    ///
    /// # Errors
    /// [`StepError::Frame`] if a frame is refused: begin again.
    pub fn begin_frames(
        &mut self,
        frames: &mut impl FrameSource,
        index: i32,
    ) -> Result<(), StepError> {
        self.desired.begin(self.controller.tree(), frames, index).map_err(StepError::Frame)
    }

    /// Tells that `ticks` were left out since the last call of [`Self::begin`] or [`Self::step`]: velocities are then
    /// differences over the time that has passed, and an observer, which does not know what was commanded meanwhile,
    /// starts anew from them. A call of [`Self::step`] that was refused is no tick left out.
    pub fn skip(&mut self, ticks: u16) {
        self.estimate.skip(ticks);
    }

    /// One tick: torques for frame `index`, from what the joints' sensors measure now. O(n).
    ///
    /// Each tick takes one frame. Poses tell a target together with those before them: in the first three ticks after a
    /// jump, such as over a tick that was left out or a frame that was refused, the targets go on as they were, at
    /// constant velocities. So a rig that was late once is not late again. Who wants the new frames at once calls
    /// [`Self::begin_frames`].
    ///
    /// A tick that is refused has taken its time: the next goes on from differences over it. Ticks that are left out
    /// must be told: see [`Self::skip`].
    ///
    /// # Errors
    /// [`StepError`] if a frame is refused, or a reading: not one for each joint, a pose that is not finite or whose
    /// rotation is not unit. There are no torques then, and the servos must be held safe.
    pub fn step<'m>(
        &mut self,
        frames: &mut impl FrameSource,
        index: i32,
        measured: impl Into<Measured<'m>>,
    ) -> Result<Tick<'_, N, D, R>, StepError> {
        let tree = self.controller.tree();
        let of_frame = self.desired.follow(tree, frames, index);
        // The reading is kept, whatever became of the frame.
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

    /// Notes that a dof swings: the measurement that follows from the last tick is observed with this share of its
    /// joint's own bandwidth, 0 to 1. O(n).
    ///
    /// The observer's path carries a swing through a soft gear; less of the feedback alone leaves it.
    pub fn note_swing(&mut self, dof: usize, share: f32) {
        if let Some(joint) = self.joint_of(dof) {
            self.estimate.observer_mut().note_share(joint, share);
        }
    }

    /// Notes that the drive of a dof could not give all that the last tick asked for: from the measurement that
    /// follows, no disturbance is learnt that would ask for more. O(n).
    pub fn note_limited(&mut self, dof: usize) {
        let Some(joint) = self.joint_of(dof) else { return };
        let bodies = self.controller.tree().bodies();
        if let (Some(body), Some(torque)) = (bodies.get(joint), self.workspace.torques().get(joint))
        {
            self.estimate.observer_mut().note_limited(joint, body, &torque.value);
        }
    }

    /// Returns the joint that has a dof.
    fn joint_of(&self, dof: usize) -> Option<usize> {
        let mut first = dof;
        self.controller.tree().bodies().iter().position(|body| {
            let count = body.joint.dof_count();
            let has_it = first < count;
            first = first.saturating_sub(count);
            has_it
        })
    }

    /// The rig's controller.
    pub fn controller(&self) -> &TorqueController<N> {
        &self.controller
    }

    /// The targets of the last tick.
    pub fn targets(&self) -> &JointTargets<N> {
        self.desired.targets()
    }

    /// The state that the torques of the last tick go by: as measured, or with an observer that which they will meet.
    pub fn states(&self) -> &JointStates<N> {
        self.estimate.states()
    }

    /// What the last tick left: commands, torques.
    pub fn workspace(&self) -> &Workspace<N, R> {
        &self.workspace
    }

    /// State errors of the last tick, see [`TorqueController::errors`].
    pub fn errors(&mut self, out: &mut [StateError]) {
        let states = self.estimate.states();
        self.controller.errors(self.desired.targets_mut(), states, &mut self.workspace, out);
    }
}

/// What a tick asks for: there is none of a tick that was refused.
#[derive(Debug)]
pub struct Tick<'t, const N: usize, const D: usize = 1, const R: usize = 0> {
    tracker: &'t mut Tracker<N, D, R>,
}

impl<const N: usize, const D: usize, const R: usize> Tick<'_, N, D, R> {
    /// The wrench of each joint's drive, as [`TorqueController::tick`] gives it.
    pub fn torques(&self) -> &[Limited<Wrench>] {
        let count = self.tracker.controller.tree().len();
        self.tracker.workspace.torques().get(..count).unwrap_or_default()
    }

    /// What the drives of the degrees of freedom are to give, N m or N: see [`Tree::efforts`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`] if `out` has not one item for each degree of freedom.
    pub fn efforts(&self, out: &mut [f32]) -> Result<(), CoordinatesError> {
        let states = self.tracker.estimate.states().as_slice();
        self.tracker.controller.tree().efforts(states, self.torques(), out)
    }

    /// What each degree of freedom is asked for: target, feed-forward and feedback effort, and what limited it. See
    /// [`TorqueController::dof_commands`]. O(n).
    ///
    /// # Errors
    /// [`CoordinatesError::Count`] if `out` has not one item for each degree of freedom.
    pub fn dof_commands(&mut self, out: &mut [DofCommand]) -> Result<(), CoordinatesError> {
        let Tracker { controller, desired, estimate, workspace, .. } = &mut *self.tracker;
        controller.dof_commands(desired.targets(), estimate.states(), &[], workspace, out)
    }
}

/// Cuts what the last tick asked for to what there is.
// Not within the tick, whose frame on the stack every rig would pay for.
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
