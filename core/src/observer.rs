//! A state observer: filters joint sensors, learns disturbances, and predicts over a known delay.

use core::fmt;

use glam::{Quat, Vec3};

use crate::control::Limited;
use crate::joint::JointKind;
use crate::joint_states::JointStates;
use crate::joint_targets::JointTargets;
use crate::math;
use crate::state::{JointState, StateInputError};
use crate::transform::{Transform, Twist, Wrench};
use crate::tree::{Body, Tree};

/// Share of a joint's own bandwidth that its observer uses while the target stands still.
///
/// With the full bandwidth, the starter arm swings by 1.8 deg if its gears have half the stiffness, twice the play
/// and a third of the damping of the model. A share of 0.7 gives 0.9 deg; 0.6 and 0.5 give at most 0.3 deg. A
/// smaller share makes a pushed joint return more slowly.
const STANDING_SHARE: f32 = 0.6;
/// Number of steps in which shares of a bandwidth are stored.
const WHOLE: f32 = 255.0;

/// Settings of the observer: the time step, gains that weigh the measurement against the prediction, and limits of the
/// disturbance.
///
/// ```
/// use sinew_core::observer::{ObserverError, ObserverSettings};
/// // At 100 ticks per second; at most 50 rad/s² are attributed to a wrong model.
/// let settings = ObserverSettings::extended_state(40.0, 0.01)?.with_disturbance_limits(50.0, 5.0)?;
/// // No filter can follow faster than once per tick.
/// let too_fast = ObserverSettings::extended_state(200.0, 0.01);
/// assert_eq!(too_fast, Err(ObserverError::Bandwidth { rad_s: 200.0 }));
/// # Ok::<(), ObserverError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct ObserverSettings {
    dt_s: f32,
    pose_gain: f32,
    velocity_gain_per_s: f32,
    disturbance_gain_per_s2: f32,
    most_rad_s2: f32,
    most_m_s2: f32,
}

impl ObserverSettings {
    /// Settings for an observer of an empty tree.
    const NOTHING: Self = Self {
        dt_s: 0.0,
        pose_gain: 0.0,
        velocity_gain_per_s: 0.0,
        disturbance_gain_per_s2: 0.0,
        most_rad_s2: 0.0,
        most_m_s2: 0.0,
    };

    /// Returns settings without filter or disturbance: poses as measured, velocities as their backward differences.
    /// Only the prediction over a delay is active.
    ///
    /// # Errors
    /// [`ObserverError`] if the time step is not a positive number, or its reciprocal is too large for f32.
    pub fn differences(dt_s: f32) -> Result<Self, ObserverError> {
        let velocity_gain_per_s = 1.0 / dt_s;
        if !(dt_s.is_finite() && dt_s > 0.0 && velocity_gain_per_s.is_finite()) {
            return Err(ObserverError::TimeStep);
        }
        Ok(Self {
            dt_s,
            pose_gain: 1.0,
            velocity_gain_per_s,
            disturbance_gain_per_s2: 0.0,
            most_rad_s2: 200.0,
            most_m_s2: 20.0,
        })
    }

    /// Returns settings of an extended state observer with this bandwidth (Han, "From PID to Active Disturbance
    /// Rejection Control", 2009; one bandwidth for all poles, Gao 2003). Acceleration that the commands do not explain
    /// is estimated as a disturbance. The effect of wrong masses, friction and loads is learnt in about `3 / bandwidth`
    /// seconds; noise above the bandwidth is filtered out.
    ///
    /// All three poles of the estimation error are at `β = exp(-bandwidth dt)`. For the step
    /// `v += dt (a + d), x += dt v`, the gains are `1 - β³`, `(1 - β)² (1 + 2β) / dt` and `(1 - β)³ / dt²`.
    ///
    /// # Errors
    /// [`ObserverError`] if the time step is not a positive number, the reciprocal of its square is too large for
    /// f32, or the bandwidth is not above 0 and at most 1 / `dt_s`.
    pub fn extended_state(bandwidth_rad_s: f32, dt_s: f32) -> Result<Self, ObserverError> {
        let differences = Self::differences(dt_s)?;
        let x = bandwidth_rad_s * dt_s;
        if !(x > 0.0 && x <= 1.0) {
            return Err(ObserverError::Bandwidth { rad_s: bandwidth_rad_s });
        }
        if !(1.0 / (dt_s * dt_s)).is_finite() {
            return Err(ObserverError::TimeStep);
        }
        Ok(differences.with_pole(math::exponential(-x)))
    }

    /// Returns these settings with the gains that place all poles at β.
    fn with_pole(&self, beta: f32) -> Self {
        let (dt_s, rest) = (self.dt_s, 1.0 - beta);
        Self {
            pose_gain: 1.0 - beta * beta * beta,
            velocity_gain_per_s: rest * rest * (1.0 + 2.0 * beta) / dt_s,
            disturbance_gain_per_s2: rest * rest * rest / (dt_s * dt_s),
            ..*self
        }
    }

    /// Sets the limits of the disturbance. They also limit how hard a blocked joint is pushed beyond the effect of
    /// the gains. Default: 200 rad/s² and 20 m/s².
    ///
    /// # Errors
    /// [`ObserverError`] if a bound is not a finite number, zero or more.
    pub fn with_disturbance_limits(
        self,
        most_rad_s2: f32,
        most_m_s2: f32,
    ) -> Result<Self, ObserverError> {
        for value in [most_rad_s2, most_m_s2] {
            if !(0.0..=f32::MAX).contains(&value) {
                return Err(ObserverError::DisturbanceLimit { value });
            }
        }
        Ok(Self { most_rad_s2, most_m_s2, ..self })
    }
}

/// An estimator of a rig's state, from the poses of its joints and the accelerations commanded to it. The observer
/// stores the commands of the last ticks, one more than the delay in ticks: at most `D`.
///
/// With inverse dynamics every joint obeys `q̈ = command + disturbance`, whatever its inertia. The estimate therefore
/// takes only a few operations per joint, and the prediction applies the commands that are on their way. O(n D).
///
/// The calls of a tick: [`Self::observe`], [`Self::compensate`],
/// [`TorqueController::tick`](crate::TorqueController::tick) with [`Self::states`] and the law of inverse dynamics,
/// [`Self::record_commands`].
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointStates, JointTargets, Twist, Transform, Tree};
/// use sinew_core::observer::{Observer, ObserverSettings};
/// use sinew_core::glam::Vec3;
/// let slide = Body {
///     parent: None,
///     joint: JointKind::Prismatic { axis: Vec3::X },
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<1>::from_bodies(&[slide])?;
/// let settings = ObserverSettings::extended_state(40.0, 0.01)?;
/// let mut observer = Observer::<1, 1>::new(settings, &JointStates::rest(&tree), 0)?;
/// // Nothing was commanded, but the slide accelerates along its axis at 2 m/s².
/// let (mut x, mut v) = (0.0, 0.0);
/// for _ in 0..60 {
///     v += 0.02;
///     x += 0.01 * v;
///     observer.record_commands(&[Twist::ZERO], &[]);
///     observer.observe(&tree, &[Transform::from_translation(Vec3::X * x)])?;
/// }
/// assert!((observer.disturbances()[0].linear.x - 2.0).abs() < 1e-3);
/// assert!((observer.states().as_slice()[0].velocity.linear.x - v).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Observer<const N: usize, const D: usize> {
    settings: ObserverSettings,
    /// Pole of each joint's own bandwidth; negative: use the settings' bandwidth.
    poles: [f32; N],
    delay: usize,
    estimates: JointStates<N>,
    disturbances: [Twist; N],
    /// Commands of the last `delay + 1` ticks, oldest first. The oldest acted in the period before the present
    /// measurement.
    sent: [[Command; N]; D],
    any_sent: bool,
    ahead: JointStates<N>,
}

/// A command to a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Command {
    acceleration: Twist,
    learning: Learning,
    /// Share of the joint's own bandwidth for the measurement that shows this command's effect, in parts of
    /// [`WHOLE`].
    share: u8,
}

/// Degree to which a joint is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stance {
    /// The target moves, or the joint has not yet been near a constant target for long enough, or the joint has no rest
    /// zone.
    Moves,
    /// The target is constant, and the joint has been near it for some time: the observer need not follow fast motion.
    Stands,
    /// The target is constant, the rest zone is fully open, and the joint is within it, or stands at most half its
    /// radius outside it.
    Rests,
}

/// Learning of a joint's disturbance from the measurement that shows a command's effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Learning {
    /// The disturbance is learnt.
    Free,
    /// The drive is at its maximum along the axis: a disturbance that asks for more torque along the axis is not
    /// learnt.
    UpToPositive,
    /// The drive is at its maximum against the axis: a disturbance that asks for more torque against the axis is
    /// not learnt.
    UpToNegative,
    /// Nothing is learnt: the torque was limited, or the joint rests.
    Frozen,
}

impl Learning {
    /// Returns the accepted part of a change learnt along an axis. The controller cancels a disturbance, so a
    /// disturbance against the axis asks for more torque along the axis.
    fn of(self, learnt: f32) -> f32 {
        match self {
            Self::Free => learnt,
            Self::UpToPositive => learnt.max(0.0),
            Self::UpToNegative => learnt.min(0.0),
            Self::Frozen => 0.0,
        }
    }
}

impl Command {
    const NONE: Self = Self { acceleration: Twist::ZERO, learning: Learning::Free, share: u8::MAX };
}

impl<const N: usize, const D: usize> Observer<N, D> {
    /// Creates an observer of a rig in the given state. Each command acts `delay` ticks after the measurement that
    /// the command responds to.
    ///
    /// # Errors
    /// [`ObserverError::Delay`] if the delay is more than `D` - 1.
    pub fn new(
        settings: ObserverSettings,
        state: &JointStates<N>,
        delay: usize,
    ) -> Result<Self, ObserverError> {
        let mut observer = Self::uninit();
        observer.init(settings, state, delay)?;
        Ok(observer)
    }

    /// Creates an observer of an empty tree, to be filled by [`init`](Self::init).
    #[inline(never)]
    pub(crate) fn uninit() -> Self {
        Self {
            settings: ObserverSettings::NOTHING,
            poles: [-1.0; N],
            delay: 0,
            estimates: JointStates::uninit(),
            disturbances: [Twist::ZERO; N],
            sent: [[Command::NONE; N]; D],
            any_sent: false,
            ahead: JointStates::uninit(),
        }
    }

    /// Initializes in place. On an error nothing changes.
    #[inline(never)]
    pub(crate) fn init(
        &mut self,
        settings: ObserverSettings,
        state: &JointStates<N>,
        delay: usize,
    ) -> Result<(), ObserverError> {
        if delay >= D {
            return Err(ObserverError::Delay { ticks: delay, most: D.saturating_sub(1) });
        }
        (self.settings, self.delay) = (settings, delay);
        self.poles.fill(-1.0);
        self.reset(state);
        self.sent.iter_mut().for_each(|tick| tick.fill(Command::NONE));
        Ok(())
    }

    /// Sets a bandwidth for each joint, rad/s; 0 selects the settings' bandwidth. See
    /// [`Bandwidth`](crate::bandwidth::Bandwidth). O(n).
    ///
    /// # Errors
    /// [`ObserverError`], and nothing changes, if the number of bandwidths is not the number of joints, a bandwidth
    /// is neither 0 nor valid for [`ObserverSettings::extended_state`], or the observer has the settings
    /// `ObserverSettings::differences`.
    pub fn set_bandwidths(&mut self, rad_s: &[f32]) -> Result<(), ObserverError> {
        let (expected, found) = (self.estimates.as_slice().len(), rad_s.len());
        if expected != found {
            return Err(ObserverError::Joints { expected, found });
        }
        let learns = self.settings.disturbance_gain_per_s2 > 0.0;
        let most = if learns { 1.0 } else { 0.0 };
        // Written so that NaN fails.
        if let Some(bad) =
            rad_s.iter().find(|rad_s| !(**rad_s >= 0.0 && **rad_s * self.settings.dt_s <= most))
        {
            return Err(ObserverError::Bandwidth { rad_s: *bad });
        }
        for (pole, rad_s) in self.poles.iter_mut().zip(rad_s) {
            let x = rad_s * self.settings.dt_s;
            *pole = if x > 0.0 { math::exponential(-x) } else { -1.0 };
        }
        Ok(())
    }

    /// Resets the observer to a state, as if it were new: the disturbances are forgotten.
    pub fn reset(&mut self, state: &JointStates<N>) {
        self.disturbances.fill(Twist::ZERO);
        self.restart(state);
    }

    /// Restarts from a state, after ticks whose measurements or commands were lost. The disturbances are kept:
    /// without them the torques would jump.
    // Never inlined: the caller's stack frame would hold copies of all joints for its whole duration.
    #[inline(never)]
    pub fn restart(&mut self, state: &JointStates<N>) {
        self.estimates = state.clone();
        self.ahead = state.clone();
        self.any_sent = false;
        let none = Command { learning: Learning::Frozen, ..Command::NONE };
        for tick in &mut self.sent {
            tick.fill(none);
        }
    }

    /// Updates the estimate with the measured poses of the joints, each in its parent's frame. O(n D).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if the number of poses is not the number of joints, or a pose is not
    /// finite or its rotation not unit.
    pub fn observe(
        &mut self,
        tree: &Tree<N>,
        measured: &[Transform],
    ) -> Result<(), StateInputError> {
        for pose in measured {
            if !pose.is_finite() {
                return Err(StateInputError::NonFinite);
            }
            if !math::is_unit(pose.rotation) {
                return Err(StateInputError::RotationNotUnit);
            }
        }
        self.observe_checked(tree, measured)
    }

    /// Updates the estimate like [`Self::observe`], from poses already checked: finite, with unit rotations.
    pub(crate) fn observe_checked(
        &mut self,
        tree: &Tree<N>,
        measured: &[Transform],
    ) -> Result<(), StateInputError> {
        let bodies = tree.bodies();
        if measured.len() != bodies.len() || self.estimates.as_slice().len() != bodies.len() {
            return Err(StateInputError::NoSuchJoint);
        }
        for (joint, (body, measured)) in bodies.iter().zip(measured).enumerate() {
            self.correct(joint, body, measured);
        }
        Ok(())
    }

    /// Returns the state at the time when a command made now will act; without a delay, the present state.
    pub fn states(&self) -> &JointStates<N> {
        if self.delay == 0 { &self.estimates } else { &self.ahead }
    }

    /// Returns the estimated disturbances: accelerations of the joints that were not commanded, in body axes.
    pub fn disturbances(&self) -> &[Twist] {
        self.disturbances.get(..self.estimates.as_slice().len()).unwrap_or_default()
    }

    /// Subtracts the disturbances from the targets' accelerations, so that they cancel. O(n).
    pub fn compensate(&self, targets: &mut JointTargets<N>) {
        for (joint, (state, disturbance)) in
            self.states().as_slice().iter().zip(&self.disturbances).enumerate()
        {
            let mut against = Twist::new(-disturbance.angular, Vec3::ZERO);
            // Most joints only turn.
            if disturbance.linear != Vec3::ZERO {
                // The linear target is a vector of the parent's frame, in the axes of the desired pose.
                let to_desired = targets
                    .states()
                    .get(joint)
                    .map_or(Quat::IDENTITY, |target| target.pose.rotation.conjugate());
                against.linear = to_desired * (state.pose.rotation * -disturbance.linear);
            }
            targets.add_acceleration(joint, against);
        }
    }

    /// Records the accelerations that were commanded to the joints
    /// ([`Workspace::commands`](crate::Workspace::commands)), and which of their torques were limited. A joint
    /// whose torque was limited learns no disturbance from the measurement that shows the command's effect.
    pub fn record_commands(&mut self, commands: &[Twist], torques: &[Limited<Wrench>]) {
        let first = !self.any_sent;
        self.any_sent = true;
        let in_flight = self.sent.get_mut(..=self.delay).unwrap_or_default();
        // `rotate_left` would panic on an empty slice, which only a delay above D - 1 could cause; `new` refuses it.
        if !first && !in_flight.is_empty() {
            in_flight.rotate_left(1);
        }
        // Before the first command takes effect, the drives are assumed to apply it already.
        let last = in_flight.len().saturating_sub(1);
        let from = if first { 0 } else { last };
        for slot in in_flight.get_mut(from..).unwrap_or_default() {
            let mut torques = torques.iter();
            for (slot, command) in slot.iter_mut().zip(commands) {
                let limited = torques.next().is_some_and(|torque| torque.reason.is_some());
                let learning = if limited { Learning::Frozen } else { Learning::Free };
                let acceleration = if command.is_finite() { *command } else { Twist::ZERO };
                *slot = Command { acceleration, learning, share: u8::MAX };
            }
        }
    }

    /// Records the stance of a joint with the command that was recorded last. A joint that does not move is observed
    /// with [`STANDING_SHARE`] of its own bandwidth, in the measurement that shows this command's effect. A joint
    /// that rests learns nothing from that measurement.
    pub(crate) fn note_stance(&mut self, joint: usize, stance: Stance) {
        if stance != Stance::Moves {
            self.note_share(joint, STANDING_SHARE);
        }
        if stance == Stance::Rests {
            self.note(joint, Learning::Frozen);
        }
    }

    /// Limits the bandwidth for the measurement that shows the effect of the last recorded command, to a share of the
    /// joint's own bandwidth, 0 to 1.
    pub(crate) fn note_share(&mut self, joint: usize, share: f32) {
        if let Some(command) = self.last_sent(joint) {
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "saturates"
            )]
            let parts = (share * WHOLE + 0.5) as u8;
            command.share = command.share.min(parts);
        }
    }

    /// Records that a joint's drive could not deliver the whole wrench of the last recorded command: a disturbance
    /// that asks for more is not learnt. Joints that are not revolute learn nothing.
    pub(crate) fn note_limited(&mut self, joint: usize, body: &Body, wrench: &Wrench) {
        let learning = match body.joint {
            JointKind::Revolute { axis } => {
                let along_nm = axis.dot(wrench.moment_nm);
                // A wrench of zero along the axis does not show in which direction more torque would be needed.
                if along_nm > 0.0 {
                    Learning::UpToPositive
                } else if along_nm < 0.0 {
                    Learning::UpToNegative
                } else {
                    Learning::Frozen
                }
            }
            _ => Learning::Frozen,
        };
        self.note(joint, learning);
    }

    fn note(&mut self, joint: usize, learning: Learning) {
        if let Some(command) = self.last_sent(joint) {
            if command.learning != Learning::Frozen {
                command.learning = learning;
            }
        }
    }

    fn last_sent(&mut self, joint: usize) -> Option<&mut Command> {
        self.sent.get_mut(self.delay).and_then(|tick| tick.get_mut(joint))
    }

    /// Predicts one joint over a tick, corrects it by its measurement, and predicts it over the delay.
    fn correct(&mut self, joint: usize, body: &Body, measured: &Transform) {
        let dt_s = self.settings.dt_s;
        let (Some(before), Some(disturbance)) =
            (self.estimates.as_slice().get(joint), self.disturbances.get_mut(joint))
        else {
            return;
        };
        let mut commands = self
            .sent
            .get(..=self.delay)
            .unwrap_or_default()
            .iter()
            .filter_map(|tick| tick.get(joint).copied());
        let made = commands.next().unwrap_or(Command::NONE);
        let own;
        let settings = match self.poles.get(joint) {
            Some(&pole) if pole >= 0.0 => {
                // The pole for a share of the bandwidth, without the term of second order in bandwidth times tick.
                let share = f32::from(made.share) / WHOLE;
                let pole = if made.share < u8::MAX { 1.0 - share * (1.0 - pole) } else { pole };
                own = self.settings.with_pole(pole);
                &own
            }
            _ => &self.settings,
        };

        let mut state = match body.joint {
            JointKind::Spherical => settings.correct_ball(before, made, measured, disturbance),
            JointKind::Revolute { axis } => {
                let about = (axis, &body.placement);
                settings.correct_hinge(about, before, made, measured, disturbance)
            }
            _ => settings.correct(body, before, made, measured, disturbance),
        };
        let disturbance = *disturbance;
        // Only numbers near the limit of f32 are refused: the joint then restarts from its measurement.
        if state.check().is_err() {
            state = JointState { pose: *measured, velocity: Twist::ZERO };
        }
        let _ = self.estimates.put(joint, state);
        if self.delay == 0 {
            return;
        }
        for command in commands {
            state = moved(&state, command.acceleration + disturbance, dt_s, body.joint.slides());
        }
        let _ = self.ahead.set(joint, state);
    }
}

impl ObserverSettings {
    /// Returns the state of a joint after a tick, and updates its disturbance from the measurement.
    #[inline]
    fn correct(
        &self,
        body: &Body,
        before: &JointState,
        made: Command,
        measured: &Transform,
        disturbance: &mut Twist,
    ) -> JointState {
        let Self { dt_s, pose_gain, velocity_gain_per_s, .. } = *self;
        let slides = body.joint.slides();
        // The motion in this tick, predicted and measured, both in the axes of the body before the tick.
        let to_body = before.pose.rotation.conjugate();
        let velocity = before.velocity + (made.acceleration + *disturbance) * dt_s;
        let expected = velocity * dt_s;
        let came = Twist {
            angular: math::log(to_body * measured.rotation),
            linear: to_body * (measured.translation_m - before.pose.translation_m),
        };
        // Only the axes of a universal joint depend on its pose.
        let in_joint = match body.joint {
            JointKind::Universal { .. } => {
                body.placement.rotation.conjugate() * before.pose.rotation
            }
            _ => Quat::IDENTITY,
        };
        let off = body.joint.project_twist(in_joint, came - expected);
        if made.learning == Learning::Free {
            let learnt = off * self.disturbance_gain_per_s2;
            *disturbance = self.bounded(*disturbance + learnt);
        }
        let way = expected + off * pose_gain;
        let velocity = velocity + off * velocity_gain_per_s;
        let mut state = before.moved(way, velocity, slides);
        if !slides {
            state.pose.translation_m = measured.translation_m;
        }
        let carried =
            keep_on_axes(body.joint, &body.placement, &before.pose, &mut state, *disturbance);
        *disturbance = if carried.is_finite() { carried } else { Twist::ZERO };
        state
    }

    /// Corrects a spherical joint, like `correct`.
    #[inline]
    fn correct_ball(
        &self,
        before: &JointState,
        made: Command,
        measured: &Transform,
        disturbance: &mut Twist,
    ) -> JointState {
        let Self { dt_s, pose_gain, velocity_gain_per_s, most_rad_s2, .. } = *self;
        let unexpected = disturbance.angular;
        let velocity = before.velocity.angular + (made.acceleration.angular + unexpected) * dt_s;
        let expected = velocity * dt_s;
        let came = math::log(math::turn_in_body(before.pose.rotation, measured.rotation));
        let off = came - expected;
        if made.learning == Learning::Free {
            let learnt = within(unexpected + off * self.disturbance_gain_per_s2, most_rad_s2);
            disturbance.angular = if math::is_finite(learnt) { learnt } else { Vec3::ZERO };
        }
        let rotation = before.pose.rotation * math::exp(expected + off * pose_gain);
        JointState {
            pose: Transform { rotation, translation_m: measured.translation_m },
            velocity: Twist::new(velocity + off * velocity_gain_per_s, before.velocity.linear),
        }
    }

    /// Corrects a revolute joint, like `correct`, with scalars along its axis.
    // Never inlined, so that joints of other kinds do not pay for its stack.
    #[inline(never)]
    fn correct_hinge(
        &self,
        (axis, placement): (Vec3, &Transform),
        before: &JointState,
        made: Command,
        measured: &Transform,
        disturbance: &mut Twist,
    ) -> JointState {
        let Self { dt_s, pose_gain, velocity_gain_per_s, most_rad_s2, .. } = *self;
        let mut unexpected = axis.dot(disturbance.angular);
        let speed = axis.dot(before.velocity.angular)
            + (axis.dot(made.acceleration.angular) + unexpected) * dt_s;
        let expected = speed * dt_s;
        let turn = math::turn_in_body(before.pose.rotation, measured.rotation);
        let off = axis.dot(math::log(turn)) - expected;
        if made.learning != Learning::Frozen {
            unexpected += made.learning.of(off * self.disturbance_gain_per_s2);
            unexpected = if unexpected.is_finite() {
                // Not `clamp`, which would panic if the bounds were NaN.
                unexpected.max(-most_rad_s2).min(most_rad_s2)
            } else {
                0.0
            };
        }
        *disturbance = Twist::new(axis * unexpected, Vec3::ZERO);
        // The new pose is computed from the joint's angle alone, because no measurement would ever correct an error
        // across the axis. These are the sine and cosine of half the angle.
        let (zero, reversed) = (placement.rotation, math::turned_half(placement.rotation, axis));
        let (sine, cosine) = (reversed.dot(before.pose.rotation), zero.dot(before.pose.rotation));
        let (of_step, along) = math::half_sin_cos(expected + off * pose_gain);
        let (sine, cosine) = (sine * along + cosine * of_step, cosine * along - sine * of_step);
        let twist = math::unit(Quat::from_xyzw(sine, 0.0, 0.0, cosine));
        let rotation = reversed * twist.x + zero * twist.w;
        JointState {
            pose: Transform { rotation, translation_m: placement.translation_m },
            velocity: Twist::new(axis * (speed + off * velocity_gain_per_s), Vec3::ZERO),
        }
    }

    fn bounded(&self, disturbance: Twist) -> Twist {
        let bounded = Twist {
            angular: within(disturbance.angular, self.most_rad_s2),
            linear: within(disturbance.linear, self.most_m_s2),
        };
        if bounded.is_finite() { bounded } else { Twist::ZERO }
    }
}

/// Projects the state of a joint with one or two axes onto these axes, after a step that was exact to first order.
/// This is necessary because no measurement would ever correct an error across the axes. Returns the acceleration
/// with the same components along the axes after the step. Joints of other kinds are unchanged.
fn keep_on_axes(
    joint: JointKind,
    placement: &Transform,
    before: &Transform,
    state: &mut JointState,
    acceleration: Twist,
) -> Twist {
    if matches!(joint, JointKind::Spherical | JointKind::Free) {
        return acceleration;
    }
    let in_joint = joint.at(joint.along(&(placement.inverse() * state.pose)));
    state.pose = *placement * in_joint;
    state.velocity = joint.project_twist(in_joint.rotation, state.velocity);
    if !matches!(joint, JointKind::Universal { .. }) {
        // The axes do not move in the body. Adding zero removes negative zeros, as in the sum below.
        return Twist::ZERO + joint.project_twist(in_joint.rotation, acceleration);
    }
    let axes_before = joint.motion_subspace(placement.rotation.conjugate() * before.rotation);
    let axes = joint.motion_subspace(in_joint.rotation);
    let mut carried = Twist::ZERO;
    for (before, now) in axes_before.iter().zip(&axes) {
        let along =
            before.angular.dot(acceleration.angular) + before.linear.dot(acceleration.linear);
        carried = carried + Twist::new(now.angular * along, now.linear * along);
    }
    carried
}

/// Returns a joint's state after one period of an acceleration in body axes: first the velocity, then the pose.
fn moved(joint: &JointState, acceleration: Twist, dt_s: f32, slides: bool) -> JointState {
    let velocity = joint.velocity + acceleration * dt_s;
    joint.moved(velocity * dt_s, velocity, slides)
}

/// Shortens a vector to a maximum length.
#[inline]
fn within(v: Vec3, most: f32) -> Vec3 {
    let squared = v.dot(v);
    if squared <= most * most { v } else { v * (most / math::sqrt(squared)) }
}

/// An error in the settings of an observer.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum ObserverError {
    /// The time step is not a positive number.
    TimeStep,
    /// The bandwidth is not above 0 and at most one over the time step.
    Bandwidth {
        /// Bandwidth, rad/s.
        rad_s: f32,
    },
    /// A bound on disturbances is not a finite number, zero or more.
    DisturbanceLimit {
        /// Bound, rad/s² or m/s².
        value: f32,
    },
    /// The number of bandwidths is not the number of joints.
    Joints {
        /// Number of joints.
        expected: usize,
        /// Number of bandwidths.
        found: usize,
    },
    /// The delay exceeds the capacity of the observer.
    Delay {
        /// Delay in ticks.
        ticks: usize,
        /// Maximum delay in ticks.
        most: usize,
    },
}

impl fmt::Display for ObserverError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TimeStep => f.write_str("the time step must be a positive number of seconds"),
            Self::Bandwidth { rad_s } => write!(
                f,
                "the bandwidth is {rad_s} rad/s; it must be above 0 and at most one over the time step"
            ),
            Self::DisturbanceLimit { value } => {
                write!(f, "the bound on disturbances is {value}; it must be a finite number from 0")
            }
            Self::Joints { expected, found } => {
                write!(f, "{expected} joints need as many bandwidths, {found} were given")
            }
            Self::Delay { ticks, most } => {
                write!(f, "a delay of {ticks} ticks; this observer has room for {most}")
            }
        }
    }
}

impl core::error::Error for ObserverError {}
