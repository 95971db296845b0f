//! States of joints and bodies, and the entrances where states come in.

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use crate::fixed;
use crate::joint::UNIT_TOLERANCE;
use crate::kinematics;
use crate::math;
use crate::trajectory::{in_axes_of, rate, step};
use crate::transform::{Transform, Twist};
use crate::tree::{Body, Tree};

/// State of a joint: pose and velocity of its body relative to the parent body.
///
/// The same type serves the desired and the measured side: the paper's "complete transforms as joint
/// parameters". A joint model says which part of it is free.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct JointState {
    /// Pose of the body in its parent's frame.
    pub pose: Transform,
    /// Velocity relative to the parent, in body axes.
    pub velocity: Twist,
}

/// The farthest that a pose's position may be where differences are taken, m. A square of it is far from
/// overflow, and so is what follows from two such positions over [`SHORTEST_STEP_S`].
const FARTHEST_M: f32 = 1e6;

/// The shortest time step that differences are taken over, s.
pub(crate) const SHORTEST_STEP_S: f32 = 1e-9;

/// Whether differences of this pose are numbers: its rotation a unit quaternion, its position not beyond
/// [`FARTHEST_M`].
#[inline]
pub(crate) fn check_pose(pose: &Transform) -> Result<(), StateInputError> {
    check_position(pose.translation_m)?;
    check_rotation(pose.rotation)
}

#[inline]
fn check_position(position_m: Vec3) -> Result<(), StateInputError> {
    // Written so that NaN fails.
    if position_m.dot(position_m) <= FARTHEST_M * FARTHEST_M {
        Ok(())
    } else {
        Err(StateInputError::NonFinite)
    }
}

/// The first `count` of some poses, checked.
#[inline]
pub(crate) fn checked_poses(
    poses: &[Transform],
    count: usize,
) -> Result<&[Transform], StateInputError> {
    let poses = poses.get(..count).ok_or(StateInputError::NoSuchJoint)?;
    poses.iter().try_for_each(check_pose)?;
    Ok(poses)
}

#[inline]
fn check_rotation(rotation: Quat) -> Result<(), StateInputError> {
    // Written so that NaN fails.
    if (rotation.dot(rotation) - 1.0).abs() <= 2.0 * UNIT_TOLERANCE {
        Ok(())
    } else {
        Err(StateInputError::RotationNotUnit)
    }
}

impl JointState {
    /// Whether every component is a number and the rotation is a unit quaternion.
    fn check(&self) -> Result<(), StateInputError> {
        if !self.pose.is_finite() || !self.velocity.is_finite() {
            return Err(StateInputError::NonFinite);
        }
        check_rotation(self.pose.rotation)
    }

    fn with_unit_rotation(mut self) -> Self {
        self.pose.rotation = math::unit(self.pose.rotation);
        self
    }
}

/// State of a body: its pose in a reference frame (mostly the world), and its velocity in the axes of
/// that frame; the linear part is the velocity of the body frame's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct BodyState {
    /// Pose in the reference frame.
    pub pose: Transform,
    /// Velocity in the axes of the reference frame.
    pub velocity: Twist,
}

impl BodyState {
    /// The world itself, at rest.
    pub const WORLD: Self = Self { pose: Transform::IDENTITY, velocity: Twist::ZERO };

    /// This state as body `reference` sees it, in the axes of `reference`. Both are given in one frame.
    ///
    /// Eq. (5) of Notman et al. (2011), with the velocities that go with it.
    ///
    /// ```
    /// use sinew_core::{BodyState, Twist, Transform, glam::Vec3};
    /// let still = BodyState { pose: Transform::from_translation(Vec3::X), ..BodyState::WORLD };
    /// let spin = BodyState { velocity: Twist::new(Vec3::Z, Vec3::ZERO), ..BodyState::WORLD };
    /// let seen = still.seen_from(&spin);
    /// assert_eq!(seen.velocity.angular, -Vec3::Z);
    /// assert_eq!(seen.velocity.linear, -Vec3::Y);
    /// ```
    #[must_use]
    pub fn seen_from(&self, reference: &Self) -> Self {
        let to_reference = reference.pose.rotation.conjugate();
        let arm = self.pose.translation_m - reference.pose.translation_m;
        let carried = reference.velocity.angular.cross(arm);
        Self {
            pose: Transform::new(
                to_reference * self.pose.rotation,
                math::rotate(to_reference, arm),
            ),
            velocity: Twist {
                angular: math::rotate(
                    to_reference,
                    self.velocity.angular - reference.velocity.angular,
                ),
                linear: math::rotate(
                    to_reference,
                    self.velocity.linear - reference.velocity.linear - carried,
                ),
            },
        }
    }

    /// State of the joint between `parent` and this body: [`Self::seen_from`], turned to body axes.
    ///
    /// ```
    /// use sinew_core::{BodyState, Transform, glam::Vec3};
    /// let at = |x| BodyState { pose: Transform::from_translation(Vec3::X * x), ..BodyState::WORLD };
    /// let joint = at(0.75).joint_state(&at(0.25));
    /// assert_eq!(joint.pose.translation_m.x, 0.5);
    /// // And the way back.
    /// assert_eq!(at(0.25).child(&joint), at(0.75));
    /// ```
    #[must_use]
    pub fn joint_state(&self, parent: &Self) -> JointState {
        let seen = self.seen_from(parent);
        JointState {
            pose: seen.pose,
            velocity: seen.velocity.rotated(seen.pose.rotation.conjugate()),
        }
    }

    /// Velocity of the joint between `parent` and this body, in body axes: that of [`Self::joint_state`].
    #[inline]
    pub(crate) fn velocity_from(&self, parent: &Self) -> Twist {
        let arm = self.pose.translation_m - parent.pose.translation_m;
        let carried = math::plus_cross(parent.velocity.linear, parent.velocity.angular, arm);
        Twist {
            angular: self.velocity.angular - parent.velocity.angular,
            linear: self.velocity.linear - carried,
        }
        .rotated(self.pose.rotation.conjugate())
    }

    /// State of a body hung on this one by a joint: the inverse of [`Self::joint_state`].
    #[must_use]
    pub fn child(&self, joint: &JointState) -> Self {
        let arm = math::rotate(self.pose.rotation, joint.pose.translation_m);
        let rotation = self.pose.rotation * joint.pose.rotation;
        let relative = joint.velocity.rotated(rotation);
        Self {
            pose: Transform::new(rotation, self.pose.translation_m + arm),
            velocity: Twist {
                angular: self.velocity.angular + relative.angular,
                linear: math::plus_cross(self.velocity.linear, self.velocity.angular, arm)
                    + relative.linear,
            },
        }
    }
}

/// States of all joints of a tree, as measured; finite and with unit rotations at all times.
///
/// This is an entrance: what comes from sensors or a file is refused here, so that the control tick need
/// not fail.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointState, JointStates, StateInputError, Transform, Tree};
/// let root = Body {
///     parent: None,
///     joint: JointKind::Spherical,
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
/// };
/// let tree = Tree::<1>::from_bodies(&[root])?;
/// let mut measured = JointStates::rest(&tree);
/// let mut bad = JointState::default();
/// bad.velocity.angular.x = f32::NAN;
/// assert_eq!(measured.set(0, bad), Err(StateInputError::NonFinite));
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct JointStates<const N: usize> {
    states: Vec<JointState, N>,
}

impl<const N: usize> JointStates<N> {
    /// All joints of `tree` at rest in its zero pose.
    pub fn rest(tree: &Tree<N>) -> Self {
        let at_rest = |body: &Body| JointState { pose: body.placement, velocity: Twist::ZERO };
        let states = fixed::collect(tree.bodies().iter().map(at_rest));
        Self { states }
    }

    /// Sets the state of one joint.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if there is no such joint, a number is not finite or
    /// the rotation not unit.
    pub fn set(&mut self, joint: usize, state: JointState) -> Result<(), StateInputError> {
        state.check()?;
        self.put(joint, state)
    }

    /// Sets the state of one joint to what is known to be finite, with a rotation that [`check_pose`] has passed.
    #[inline]
    pub(crate) fn put(&mut self, joint: usize, state: JointState) -> Result<(), StateInputError> {
        let slot = self.states.get_mut(joint).ok_or(StateInputError::NoSuchJoint)?;
        *slot = state.with_unit_rotation();
        Ok(())
    }

    /// Takes poses as those of a rig at rest: where it stood before is not known. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if a joint has no pose, or one that is not finite or unit.
    pub fn stand(&mut self, poses: &[Transform]) -> Result<(), StateInputError> {
        let poses = checked_poses(poses, self.states.len())?;
        for (state, pose) in self.states.iter_mut().zip(poses) {
            *state = JointState { pose: *pose, velocity: Twist::ZERO }.with_unit_rotation();
        }
        Ok(())
    }

    /// Takes newly measured poses, `elapsed_s` after those that it has: the velocities are the backward differences
    /// (13). What [`backward_states`](crate::trajectory::backward_states) makes of two frames, without the one before
    /// to be kept and checked again. O(n).
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointStates, StateInputError, Transform, Tree, glam::Vec3};
    /// let slide = Body {
    ///     parent: None,
    ///     joint: JointKind::Prismatic { axis: Vec3::X },
    ///     placement: Transform::IDENTITY,
    ///     inertia: Inertia::default(),
    /// };
    /// let tree = Tree::<1>::from_bodies(&[slide]).map_err(|_| StateInputError::NoSuchJoint)?;
    /// let mut measured = JointStates::rest(&tree);
    /// measured.stand(&[Transform::from_translation(Vec3::X)])?;
    /// measured.follow(&[Transform::from_translation(Vec3::X * 1.5)], 0.25)?;
    /// assert_eq!(measured.as_slice()[0].velocity.linear.x, 2.0);
    /// # Ok::<(), StateInputError>(())
    /// ```
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if a joint has no pose, or one that is not finite or unit, or the
    /// time is not a positive number (from 1e-9 s).
    pub fn follow(&mut self, poses: &[Transform], elapsed_s: f32) -> Result<(), StateInputError> {
        let (poses, rate_hz) = (checked_poses(poses, self.states.len())?, rate(elapsed_s)?);
        // Where the rig was may have come by other ways, which let farther poses in.
        self.states.iter().try_for_each(|state| check_position(state.pose.translation_m))?;
        for (state, pose) in self.states.iter_mut().zip(poses) {
            let pose = Transform { rotation: math::unit(pose.rotation), ..*pose };
            let mut velocity = step(&state.pose, &pose, rate_hz);
            // Most joints only turn: their bodies' origins stay where they are in the parent's frame.
            if velocity.linear != Vec3::ZERO {
                velocity = in_axes_of(&pose, velocity);
            }
            *state = JointState { pose, velocity };
        }
        Ok(())
    }

    /// The states by joint.
    pub fn as_slice(&self) -> &[JointState] {
        &self.states
    }
}

/// Where all joints of a tree should be, how fast, and with what acceleration.
///
/// An entrance like [`JointStates`].
///
/// ```
/// use sinew_core::{JointState, JointTargets, Twist, StateInputError, glam::Vec3};
/// # use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// # let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// # let head = Body { parent, joint, placement, inertia: Inertia::default() };
/// let tree = Tree::<1>::from_bodies(&[head])?;
/// let mut targets = JointTargets::rest(&tree);
/// let turning = JointState { velocity: Twist::new(Vec3::Y, Vec3::ZERO), ..JointState::default() };
/// targets.set(0, turning, Twist::new(Vec3::Y * 4.0, Vec3::ZERO))?;
/// assert_eq!(targets.accelerations()[0].angular.y, 4.0);
/// assert_eq!(targets.set(1, turning, Twist::ZERO), Err(StateInputError::NoSuchJoint));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct JointTargets<const N: usize> {
    states: Vec<JointState, N>,
    accelerations: Vec<Twist, N>,
    /// The world states of the bodies that follow from `states` in a tree of this shape, once somebody knows them.
    bodies: Vec<BodyState, N>,
    known_for: Option<u32>,
}

/// Equal if the joints' targets are: the bodies' follow from them.
impl<const N: usize> PartialEq for JointTargets<N> {
    fn eq(&self, other: &Self) -> bool {
        self.states == other.states && self.accelerations == other.accelerations
    }
}

impl<const N: usize> JointTargets<N> {
    /// All joints of `tree` at rest in its zero pose.
    pub fn rest(tree: &Tree<N>) -> Self {
        let states: Vec<JointState, N> = JointStates::rest(tree).states;
        let accelerations = fixed::collect(states.iter().map(|_| Twist::ZERO));
        let bodies = fixed::collect(states.iter().map(|_| BodyState::WORLD));
        Self { states, accelerations, bodies, known_for: None }
    }

    /// Sets state and acceleration of one joint. The acceleration is relative to the parent, in (desired)
    /// body axes: its angular part the derivative of the components of the angular velocity, its linear
    /// part the second derivative of the position in the parent's frame, turned to body axes.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if there is no such joint, a number is not finite or
    /// the rotation not unit.
    pub fn set(
        &mut self,
        joint: usize,
        state: JointState,
        acceleration: Twist,
    ) -> Result<(), StateInputError> {
        state.check()?;
        if !acceleration.is_finite() {
            return Err(StateInputError::NonFinite);
        }
        self.put(joint, state, acceleration)
    }

    /// Sets state and acceleration of one joint to what is known to be finite, with a rotation that [`check_pose`]
    /// has passed.
    #[inline]
    pub(crate) fn put(
        &mut self,
        joint: usize,
        state: JointState,
        acceleration: Twist,
    ) -> Result<(), StateInputError> {
        let (Some(slot), Some(acceleration_slot)) =
            (self.states.get_mut(joint), self.accelerations.get_mut(joint))
        else {
            return Err(StateInputError::NoSuchJoint);
        };
        *slot = state.with_unit_rotation();
        *acceleration_slot = acceleration;
        self.known_for = None;
        Ok(())
    }

    /// Sets only the velocity of one joint, relative to the parent, in (desired) body axes: zero for a
    /// performance that gives poses alone.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if there is no such joint or a number is not finite.
    pub fn set_velocity(&mut self, joint: usize, velocity: Twist) -> Result<(), StateInputError> {
        if !velocity.is_finite() {
            return Err(StateInputError::NonFinite);
        }
        let slot = self.states.get_mut(joint).ok_or(StateInputError::NoSuchJoint)?;
        slot.velocity = velocity;
        self.known_for = None;
        Ok(())
    }

    /// All targets as slices, to be set as a whole: states, accelerations, and the world states that follow from them in
    /// a tree, which count as known from here on. Finite, and with unit rotations.
    pub(crate) fn whole(
        &mut self,
        tree: &Tree<N>,
    ) -> (&mut [JointState], &mut [Twist], &mut [BodyState]) {
        self.known_for = (self.states.len() == tree.len()).then_some(tree.shape());
        (&mut self.states, &mut self.accelerations, &mut self.bodies)
    }

    /// World states of the bodies of a tree, found from those of the joints if nobody has yet.
    pub(crate) fn complete(&mut self, tree: &Tree<N>) {
        if self.known_for != Some(tree.shape()) {
            kinematics::body_states(tree.bodies(), &self.states, &mut self.bodies);
            self.known_for = Some(tree.shape());
        }
    }

    /// World states of the bodies after [`Self::complete`].
    pub(crate) fn bodies(&self) -> &[BodyState] {
        &self.bodies
    }

    /// Adds to the acceleration of one joint what is finite of a sum.
    pub(crate) fn add_acceleration(&mut self, joint: usize, more: Twist) {
        if let Some(slot) = self.accelerations.get_mut(joint) {
            let sum = *slot + more;
            if sum.is_finite() {
                *slot = sum;
            }
        }
    }

    /// The desired states by joint.
    pub fn states(&self) -> &[JointState] {
        &self.states
    }

    /// The desired accelerations by joint, see [`Self::set`].
    pub fn accelerations(&self) -> &[Twist] {
        &self.accelerations
    }
}

/// Why a state was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StateInputError {
    /// A component is NaN or infinite.
    NonFinite,
    /// The rotation is not a unit quaternion.
    RotationNotUnit,
    /// The tree has no joint of that index.
    NoSuchJoint,
    /// The time step of a difference is not a positive number.
    TimeStep,
}

impl fmt::Display for StateInputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NonFinite => "a component of the state is not finite",
            Self::RotationNotUnit => "the rotation is not a unit quaternion",
            Self::NoSuchJoint => "the tree has no joint of that index",
            Self::TimeStep => "the time step must be a positive number of seconds",
        })
    }
}

impl core::error::Error for StateInputError {}
