//! Targets of all joints of a tree: the checked container of desired states.

use heapless::Vec;

use crate::fixed;
use crate::joint_states::JointStates;
use crate::kinematics;
use crate::state::{BodyState, JointState, StateInputError};
use crate::transform::Twist;
use crate::tree::Tree;

/// Desired states and accelerations of all joints of a tree.
///
/// Setters refuse invalid values, like those of [`JointStates`].
///
/// ```
/// use sinew_core::{JointState, JointTargets, Twist, StateInputError, glam::Vec3};
/// # use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
/// # let (parent, joint, placement) = (None, JointKind::Spherical, Transform::IDENTITY);
/// # let head = Body { parent, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 };
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
    /// World states of the bodies, computed from `states`; `known` tracks which parts are valid.
    bodies: Vec<BodyState, N>,
    known: Known,
}

/// The valid part of the bodies' world states, with the shape of the tree they were computed for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Known {
    Nothing,
    /// The part that [`kinematics::body_turns`] computes.
    Turns(u32),
    All(u32),
}

/// Compares the targets of the joints. Those of the bodies follow from them.
impl<const N: usize> PartialEq for JointTargets<N> {
    fn eq(&self, other: &Self) -> bool {
        self.states == other.states && self.accelerations == other.accelerations
    }
}

impl<const N: usize> JointTargets<N> {
    /// Returns the targets of all joints of `tree` at rest in its zero pose.
    pub fn rest(tree: &Tree<N>) -> Self {
        let at_rest = JointStates::rest(tree);
        let states: Vec<JointState, N> = fixed::collect(at_rest.as_slice().iter().copied());
        let accelerations = fixed::collect(states.iter().map(|_| Twist::ZERO));
        let bodies = fixed::collect(states.iter().map(|_| BodyState::WORLD));
        Self { states, accelerations, bodies, known: Known::Nothing }
    }

    /// Creates targets of an empty tree.
    pub(crate) fn uninit() -> Self {
        let (states, accelerations, bodies) = (Vec::new(), Vec::new(), Vec::new());
        Self { states, accelerations, bodies, known: Known::Nothing }
    }

    /// Sets state and acceleration of one joint. The acceleration is relative to the parent, in (desired) body axes.
    /// Its angular part is the derivative of the components of the angular velocity. Its linear part is the second
    /// derivative of the position in the parent's frame, turned to body axes.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if there is no such joint, a number is not finite or the rotation
    /// not unit.
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

    /// Sets state and acceleration of one joint to finite values, with a rotation that has passed [`check_pose`].
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
        self.known = Known::Nothing;
        Ok(())
    }

    /// Sets only the velocity of one joint, relative to the parent, in (desired) body axes: zero for a performance
    /// that has only poses.
    ///
    /// # Errors
    /// [`StateInputError`], and nothing changes, if there is no such joint or a number is not finite.
    pub fn set_velocity(&mut self, joint: usize, velocity: Twist) -> Result<(), StateInputError> {
        if !velocity.is_finite() {
            return Err(StateInputError::NonFinite);
        }
        let slot = self.states.get_mut(joint).ok_or(StateInputError::NoSuchJoint)?;
        slot.velocity = velocity;
        self.known = Known::Nothing;
        Ok(())
    }

    /// Moves all joints of a tree on at constant velocity, and sets their accelerations to zero. A joint whose pose
    /// would become invalid stays. O(n).
    #[inline(never)]
    pub(crate) fn go_on(&mut self, tree: &Tree<N>, dt_s: f32) {
        for (body, (state, acceleration)) in
            tree.bodies().iter().zip(self.states.iter_mut().zip(&mut self.accelerations))
        {
            let velocity = state.velocity;
            let moved = state.moved(velocity * dt_s, velocity, body.joint.slides());
            if moved.check().is_ok() {
                *state = moved.with_unit_rotation();
            }
            *acceleration = Twist::ZERO;
        }
        self.known = Known::Nothing;
    }

    /// Returns all targets as slices, for code that sets every item: states, accelerations, and world states of the
    /// bodies. If `tree` has as many bodies as there are targets, the world states then count as valid. All values must
    /// be finite, and rotations unit quaternions.
    pub(crate) fn whole(
        &mut self,
        tree: &Tree<N>,
    ) -> (&mut [JointState], &mut [Twist], &mut [BodyState]) {
        let fits = self.states.len() == tree.len();
        self.known = if fits { Known::All(tree.shape()) } else { Known::Nothing };
        (&mut self.states, &mut self.accelerations, &mut self.bodies)
    }

    /// Computes the world states of the bodies of a tree from those of the joints, unless they are valid already.
    pub(crate) fn complete(&mut self, tree: &Tree<N>) {
        let all = Known::All(tree.shape());
        if self.known != all {
            kinematics::body_states(tree.bodies(), &self.states, &mut self.bodies);
            self.known = all;
        }
    }

    /// Completes world states like [`Self::complete`], but for bodies with a parent only rotations and angular
    /// velocities. O(n), or O(1) if these are valid already.
    pub(crate) fn complete_turns(&mut self, tree: &Tree<N>) {
        let turns = Known::Turns(tree.shape());
        if self.known != Known::All(tree.shape()) && self.known != turns {
            kinematics::body_turns(tree.bodies(), &self.states, &mut self.bodies);
            self.known = turns;
        }
    }

    /// Returns the world states of the bodies, as far as [`Self::complete`] or [`Self::complete_turns`] has computed
    /// them.
    pub(crate) fn bodies(&self) -> &[BodyState] {
        &self.bodies
    }

    /// Adds to the acceleration of one joint, unless the sum is not finite.
    pub(crate) fn add_acceleration(&mut self, joint: usize, more: Twist) {
        if let Some(slot) = self.accelerations.get_mut(joint) {
            let sum = *slot + more;
            if sum.is_finite() {
                *slot = sum;
            }
        }
    }

    /// Returns the desired states by joint.
    pub fn states(&self) -> &[JointState] {
        &self.states
    }

    /// Returns the desired accelerations by joint, see [`Self::set`].
    pub fn accelerations(&self) -> &[Twist] {
        &self.accelerations
    }
}
