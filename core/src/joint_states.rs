//! States of all joints of a tree: the checked container of measured states.

use glam::Vec3;
use heapless::Vec;

use crate::fixed;
use crate::math;
use crate::pose_step::{in_axes_of, rate, step};
use crate::state::{JointState, StateInputError, check_position, checked_poses};
use crate::transform::{Transform, Twist};
use crate::tree::{Body, Tree};

/// Measured states of all joints of a tree, always finite and with unit rotations.
///
/// Invalid values from sensors or a file are refused at this point, so that the control tick cannot fail.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointState, JointStates, StateInputError, Transform, Tree};
/// let root = Body {
///     parent: None,
///     joint: JointKind::Spherical,
///     placement: Transform::IDENTITY,
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
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
    /// Returns the states of all joints of `tree` at rest in its zero pose.
    pub fn rest(tree: &Tree<N>) -> Self {
        let at_rest = |body: &Body| JointState { pose: body.placement, velocity: Twist::ZERO };
        let states = fixed::collect(tree.bodies().iter().map(at_rest));
        Self { states }
    }

    /// Creates states of an empty tree.
    pub(crate) fn uninit() -> Self {
        Self { states: Vec::new() }
    }

    /// Sets the state of one joint.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if there is no such joint, a number is not finite or the rotation
    /// not unit.
    pub fn set(&mut self, joint: usize, state: JointState) -> Result<(), StateInputError> {
        state.check()?;
        self.put(joint, state)
    }

    /// Sets the state of one joint to a finite state whose rotation has passed [`check_pose`].
    #[inline]
    pub(crate) fn put(&mut self, joint: usize, state: JointState) -> Result<(), StateInputError> {
        let slot = self.states.get_mut(joint).ok_or(StateInputError::NoSuchJoint)?;
        *slot = state.with_unit_rotation();
        Ok(())
    }

    /// Sets the poses of all joints, with zero velocities: for the first measurement, which has no predecessor. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if a pose is missing or not finite, its rotation is not unit, or its
    /// position is more than 1e6 m from the parent.
    pub fn set_at_rest(&mut self, poses: &[Transform]) -> Result<(), StateInputError> {
        let poses = checked_poses(poses, self.states.len())?;
        for (state, pose) in self.states.iter_mut().zip(poses) {
            *state = JointState { pose: *pose, velocity: Twist::ZERO }.with_unit_rotation();
        }
        Ok(())
    }

    /// Sets the poses of all joints to newly measured ones. The velocities become the backward differences (13) from
    /// the previous poses, `elapsed_s` earlier. The result equals that of
    /// [`backward_states`](crate::trajectory::backward_states) for two frames, but the earlier frame is not checked
    /// again. O(n).
    ///
    /// ```
    /// use sinew_core::{Body, Inertia, JointKind, JointStates, StateInputError, Transform, Tree, glam::Vec3};
    /// let slide = Body {
    ///     parent: None,
    ///     joint: JointKind::Prismatic { axis: Vec3::X },
    ///     placement: Transform::IDENTITY,
    ///     inertia: Inertia::default(),
    ///     rotor_inertia: 0.0,
    /// };
    /// let tree = Tree::<1>::from_bodies(&[slide]).map_err(|_| StateInputError::NoSuchJoint)?;
    /// let mut measured = JointStates::rest(&tree);
    /// measured.set_at_rest(&[Transform::from_translation(Vec3::X)])?;
    /// measured.update_poses(&[Transform::from_translation(Vec3::X * 1.5)], 0.25)?;
    /// assert_eq!(measured.as_slice()[0].velocity.linear.x, 2.0);
    /// # Ok::<(), StateInputError>(())
    /// ```
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if a pose is missing or not finite, its rotation is not unit, a new or
    /// a previous position is more than 1e6 m from the parent, or the time is not a positive number (at least 1e-9 s).
    pub fn update_poses(
        &mut self,
        poses: &[Transform],
        elapsed_s: f32,
    ) -> Result<(), StateInputError> {
        let poses = checked_poses(poses, self.states.len())?;
        let rate_hz = self.rate(elapsed_s)?;
        for (state, pose) in self.states.iter_mut().zip(poses) {
            move_on(state, *pose, rate_hz);
        }
        Ok(())
    }

    /// Returns the number of steps per second, if a difference from the current poses is valid.
    pub(crate) fn rate(&self, elapsed_s: f32) -> Result<f32, StateInputError> {
        let rate_hz = rate(elapsed_s)?;
        // Other setters accept positions that are too distant for a difference, so the current ones are checked.
        self.states.iter().try_for_each(|state| check_position(state.pose.translation_m))?;
        Ok(rate_hz)
    }

    /// Moves one joint to a pose that would pass [`check_pose`](crate::state::check_pose), at a rate from
    /// [`Self::rate`].
    pub(crate) fn move_on(&mut self, joint: usize, pose: Transform, rate_hz: f32) {
        if let Some(state) = self.states.get_mut(joint) {
            move_on(state, pose, rate_hz);
        }
    }

    /// Returns the states by joint.
    pub fn as_slice(&self) -> &[JointState] {
        &self.states
    }
}

/// Moves a state on by the step to a pose, whose rotation is normalised.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
fn move_on(state: &mut JointState, pose: Transform, rate_hz: f32) {
    let pose = Transform { rotation: math::unit(pose.rotation), ..pose };
    let mut velocity = step(&state.pose, &pose, rate_hz);
    // Most joints only rotate: their bodies' origins are fixed in the parent's frame.
    if velocity.linear != Vec3::ZERO {
        velocity = in_axes_of(&pose, velocity);
    }
    *state = JointState { pose, velocity };
}
