//! States of all joints of a tree: the entrance of what is measured.

use glam::Vec3;
use heapless::Vec;

use crate::fixed;
use crate::math;
use crate::pose_step::{in_axes_of, rate, step};
use crate::state::{JointState, StateInputError, check_position, checked_poses};
use crate::transform::{Transform, Twist};
use crate::tree::{Body, Tree};

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
    /// All joints of `tree` at rest in its zero pose.
    pub fn rest(tree: &Tree<N>) -> Self {
        let at_rest = |body: &Body| JointState { pose: body.placement, velocity: Twist::ZERO };
        let states = fixed::collect(tree.bodies().iter().map(at_rest));
        Self { states }
    }

    /// Creates states of no joints.
    pub(crate) fn uninit() -> Self {
        Self { states: Vec::new() }
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

    /// Sets the poses of all joints, and their velocities to zero: for the first measurement, when nothing is known
    /// of the one before. O(n).
    ///
    /// # Errors
    /// [`StateInputError`], and nothing is changed, if a joint has no pose, or one that is not finite or unit.
    pub fn set_at_rest(&mut self, poses: &[Transform]) -> Result<(), StateInputError> {
        let poses = checked_poses(poses, self.states.len())?;
        for (state, pose) in self.states.iter_mut().zip(poses) {
            *state = JointState { pose: *pose, velocity: Twist::ZERO }.with_unit_rotation();
        }
        Ok(())
    }

    /// Sets the poses of all joints to newly measured ones, and their velocities to the backward differences (13)
    /// from the poses so far, `elapsed_s` earlier. The same as
    /// [`backward_states`](crate::trajectory::backward_states) of two frames, but the earlier one is not checked
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
    /// [`StateInputError`], and nothing is changed, if a joint has no pose, or one that is not finite or unit, or the
    /// time is not a positive number (from 1e-9 s).
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

    /// The steps in a second, if a difference from the poses so far can be.
    pub(crate) fn rate(&self, elapsed_s: f32) -> Result<f32, StateInputError> {
        let rate_hz = rate(elapsed_s)?;
        // Where the rig was may have come by other ways, which let farther poses in.
        self.states.iter().try_for_each(|state| check_position(state.pose.translation_m))?;
        Ok(rate_hz)
    }

    /// Moves one joint on to a pose that [`check_pose`](crate::state::check_pose) would pass, at a rate of
    /// [`Self::rate`].
    pub(crate) fn move_on(&mut self, joint: usize, pose: Transform, rate_hz: f32) {
        if let Some(state) = self.states.get_mut(joint) {
            move_on(state, pose, rate_hz);
        }
    }

    /// The states by joint.
    pub fn as_slice(&self) -> &[JointState] {
        &self.states
    }
}

/// The state after the step to a pose, whose rotation is made unit.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
fn move_on(state: &mut JointState, pose: Transform, rate_hz: f32) {
    let pose = Transform { rotation: math::unit(pose.rotation), ..pose };
    let mut velocity = step(&state.pose, &pose, rate_hz);
    // Most joints only turn: their bodies' origins stay where they are in the parent's frame.
    if velocity.linear != Vec3::ZERO {
        velocity = in_axes_of(&pose, velocity);
    }
    *state = JointState { pose, velocity };
}
