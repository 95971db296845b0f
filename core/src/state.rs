//! States of a joint and of a body, and their validation.

use core::fmt;

use glam::{Quat, Vec3};

use crate::math;
use crate::transform::{Transform, Twist};

/// State of a joint: pose and velocity of its body relative to the parent body.
///
/// Desired and measured states have the same type: the paper's "complete transforms as joint parameters". The joint
/// model determines which part of the state is variable.
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

/// Maximum distance of a position for differences, m. Its square is far from overflow, and so are results from two
/// such positions over the shortest time step (see `pose_step`).
const FARTHEST_M: f32 = 1e6;

/// Checks that differences of this pose are valid: its rotation is a unit quaternion, and its position is at most
/// [`FARTHEST_M`] from the origin of the parent's frame.
#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn check_pose(pose: &Transform) -> Result<(), StateInputError> {
    check_position(pose.translation_m)?;
    check_rotation(pose.rotation)
}

#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
pub(crate) fn check_position(position_m: Vec3) -> Result<(), StateInputError> {
    // Written so that NaN fails.
    if position_m.dot(position_m) <= FARTHEST_M * FARTHEST_M {
        Ok(())
    } else {
        Err(StateInputError::NonFinite)
    }
}

/// Returns the first `count` poses after checking them.
#[inline]
pub(crate) fn checked_poses(
    poses: &[Transform],
    count: usize,
) -> Result<&[Transform], StateInputError> {
    let poses = poses.get(..count).ok_or(StateInputError::NoSuchJoint)?;
    poses.iter().try_for_each(check_pose)?;
    Ok(poses)
}

#[expect(
    clippy::inline_always,
    reason = "a few operations per tick, shared by several callers: a call would cost as much"
)]
#[inline(always)]
fn check_rotation(rotation: Quat) -> Result<(), StateInputError> {
    if math::is_unit(rotation) { Ok(()) } else { Err(StateInputError::RotationNotUnit) }
}

impl JointState {
    /// Checks that every component is finite and the rotation is a unit quaternion.
    pub(crate) fn check(&self) -> Result<(), StateInputError> {
        let zero = math::zero_of_numbers(self.pose.translation_m)
            + math::zero_of_numbers(self.velocity.angular)
            + math::zero_of_numbers(self.velocity.linear);
        // A unit rotation is finite.
        if zero == 0.0 && math::is_unit(self.pose.rotation) {
            return Ok(());
        }
        if zero == 0.0 && self.pose.rotation.is_finite() {
            Err(StateInputError::RotationNotUnit)
        } else {
            Err(StateInputError::NonFinite)
        }
    }

    #[expect(
        clippy::inline_always,
        reason = "a few operations per tick, shared by several callers: a call would cost as much"
    )]
    #[inline(always)]
    pub(crate) fn with_unit_rotation(mut self) -> Self {
        self.pose.rotation = math::unit(self.pose.rotation);
        self
    }

    /// Returns the joint after a displacement, with its new velocity. Both are given in the axes of the body before
    /// the displacement.
    pub(crate) fn moved(&self, way: Twist, velocity: Twist, slides: bool) -> Self {
        let turn = math::exp(way.angular);
        let mut pose = Transform { rotation: self.pose.rotation * turn, ..self.pose };
        let mut velocity = velocity;
        if slides {
            pose.translation_m += self.pose.rotation * way.linear;
            // A rotation about the axis of the angular velocity does not change the components of that velocity; it
            // does change the components of the linear velocity.
            velocity.linear = turn.conjugate() * velocity.linear;
        } else {
            velocity.linear = self.velocity.linear;
        }
        Self { pose, velocity }
    }
}

/// State of a body: its pose in a reference frame (usually the world), and its velocity in the axes of that frame.
/// The linear part is the velocity of the body frame's origin.
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
    /// The world frame at rest.
    pub const WORLD: Self = Self { pose: Transform::IDENTITY, velocity: Twist::ZERO };

    /// Returns this state relative to body `reference`, in the axes of `reference`. Both are given in the same frame.
    ///
    /// Eq. (5) of Notman et al. (2011), with the corresponding velocities.
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

    /// Returns the state of the joint between `parent` and this body: [`Self::seen_from`], with the velocity in body
    /// axes.
    ///
    /// ```
    /// use sinew_core::{BodyState, Transform, glam::Vec3};
    /// let at = |x| BodyState { pose: Transform::from_translation(Vec3::X * x), ..BodyState::WORLD };
    /// let joint = at(0.75).joint_state(&at(0.25));
    /// assert_eq!(joint.pose.translation_m.x, 0.5);
    /// // The inverse.
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

    /// Returns the velocity of the joint between `parent` and this body, in body axes: that of [`Self::joint_state`].
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

    /// Returns the state of a child body that a joint connects to this body: the inverse of [`Self::joint_state`].
    #[must_use]
    pub fn child(&self, joint: &JointState) -> Self {
        let arm = math::rotate(self.pose.rotation, joint.pose.translation_m);
        let rotation = self.pose.rotation * joint.pose.rotation;
        let turning = math::rotate(rotation, joint.velocity.angular);
        let mut linear = math::plus_cross(self.velocity.linear, self.velocity.angular, arm);
        // Most joints only rotate.
        if joint.velocity.linear != Vec3::ZERO {
            linear += math::rotate(rotation, joint.velocity.linear);
        }
        Self {
            pose: Transform::new(rotation, self.pose.translation_m + arm),
            velocity: Twist { angular: self.velocity.angular + turning, linear },
        }
    }
}

/// An error in a state, or in a difference of states.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum StateInputError {
    /// A component is NaN or infinite, or a position is too far from the parent for differences (more than 1e6 m).
    NonFinite,
    /// The rotation is not a unit quaternion.
    RotationNotUnit,
    /// The tree has no joint with this index, or there are fewer poses or items than joints.
    NoSuchJoint,
    /// The time step of a difference is not a positive number (at least 1e-9 s).
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
