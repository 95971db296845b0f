//! Converts between the state of one joint and its coordinates.

use core::fmt;

use glam::{Quat, Vec3};

use crate::joint::JointKind;
use crate::math;
use crate::state::JointState;
use crate::transform::{Transform, Twist};

impl JointKind {
    /// Returns the state of a joint from its coordinates, in the form that servos and encoders use.
    ///
    /// `position` is empty (fixed), an angle in rad (revolute), a displacement in m (prismatic), two angles in rad
    /// (universal), a unit quaternion xyzw (spherical), or a quaternion then x y z in m (free). `speed` is in rad/s
    /// or m/s along the columns of the motion subspace. `placement` is the pose of the joint frame in the parent's
    /// frame.
    ///
    /// # Errors
    /// [`JointCoordinatesError`] if a count is wrong, a number is not finite, a quaternion is not unit, or the state
    /// is too large for f32.
    ///
    /// ```
    /// use sinew_core::{JointKind, Transform, glam::Vec3, math};
    /// let elbow = JointKind::Revolute { axis: Vec3::X };
    /// let state = elbow.state(Transform::IDENTITY, &[0.5], &[2.0])?;
    /// assert_eq!(state.pose.rotation, math::exp(Vec3::X * 0.5));
    /// assert_eq!(state.velocity.angular, Vec3::X * 2.0);
    /// # Ok::<(), sinew_core::JointCoordinatesError>(())
    /// ```
    pub fn state(
        self,
        placement: Transform,
        position: &[f32],
        speed: &[f32],
    ) -> Result<JointState, JointCoordinatesError> {
        use JointCoordinatesError as E;
        if let Some(index) = position.iter().chain(speed).position(|x| !x.is_finite()) {
            return Err(E::NonFinite { index });
        }
        for (expected, found) in
            [(self.coordinate_count(), position.len()), (self.dof_count(), speed.len())]
        {
            if found != expected {
                return Err(E::Count { expected, found });
            }
        }
        if let Some(squared) = squared_length_off_unit(position) {
            return Err(E::NotUnit { squared });
        }
        let state = self.state_at(placement, position, speed);
        if state.pose.is_finite() && state.velocity.is_finite() {
            Ok(state)
        } else {
            Err(E::Overflow)
        }
    }

    /// Returns the state like [`Self::state`], for checked coordinates. Missing coordinates count as zero.
    pub(super) fn state_at(
        self,
        placement: Transform,
        position: &[f32],
        speed: &[f32],
    ) -> JointState {
        let unit = |x, y, z, w| math::unit(Quat::from_xyzw(x, y, z, w));
        let in_joint = match (self, position) {
            (Self::Revolute { axis }, &[a]) => {
                // A shortcut that avoids the branches and the columns of the other kinds.
                let rotation = placement.rotation * math::exp(axis * a);
                let speed = speed.first().copied().unwrap_or_default();
                return JointState {
                    pose: Transform { rotation, ..placement },
                    velocity: turning(axis * speed),
                };
            }
            (Self::Prismatic { .. }, &[a]) => self.at([a, 0.0]),
            (Self::Universal { .. }, &[a, b]) => self.at([a, b]),
            (Self::Spherical, &[x, y, z, w]) => Transform::new(unit(x, y, z, w), Vec3::ZERO),
            (Self::Free, &[x, y, z, w, px, py, pz]) => {
                Transform::new(unit(x, y, z, w), Vec3::new(px, py, pz))
            }
            _ => Transform::IDENTITY,
        };
        let velocity = self.twist_along(in_joint.rotation, speed);
        JointState { pose: placement * in_joint, velocity }
    }

    /// Returns S times `numbers`: the twist of speeds or accelerations along the axes, in body axes.
    pub(super) fn twist_along(self, rotation: Quat, numbers: &[f32]) -> Twist {
        // Revolute and spherical joints, the most frequent kinds, need no columns.
        match (self, numbers) {
            (Self::Revolute { axis }, &[speed]) => return turning(axis * speed),
            (Self::Spherical, &[x, y, z]) => return turning(Vec3::new(x, y, z)),
            _ => {}
        }
        self.motion_subspace(rotation)
            .iter()
            .zip(numbers)
            .fold(Twist::ZERO, |sum, (column, number)| sum + *column * *number)
    }

    /// Writes Sᵀ times `twist`: the components of the twist along the axes. The rest of `out` is unchanged.
    pub(super) fn components(self, rotation: Quat, twist: Twist, out: &mut [f32]) {
        match self {
            Self::Revolute { axis } => return copy([0.0 + axis.dot(twist.angular)], out),
            Self::Spherical => return copy((Vec3::ZERO + twist.angular).to_array(), out),
            _ => {}
        }
        for (column, slot) in self.motion_subspace(rotation).iter().zip(out) {
            *slot = column.angular.dot(twist.angular) + column.linear.dot(twist.linear);
        }
    }

    /// Writes the coordinates of the valid pose nearest to `in_joint`: the inverse of [`Self::state`]. Angles are in
    /// [-π, π].
    pub(super) fn write_position(self, in_joint: &Transform, out: &mut [f32]) {
        let Quat { x, y, z, w } = in_joint.rotation;
        let position = in_joint.translation_m.to_array();
        match self {
            Self::Spherical | Self::Free => copy([x, y, z, w].into_iter().chain(position), out),
            _ => copy(self.along(in_joint), out),
        }
    }
}

/// Returns a pure rotation rate. Adding zero removes negative zeros, as in the sum over columns.
fn turning(angular: Vec3) -> Twist {
    Twist::new(Vec3::ZERO + angular, Vec3::ZERO)
}

/// Returns the squared length of a joint's quaternion if the quaternion is not unit. A joint without a quaternion has
/// fewer than four coordinates and gives `None`.
pub(super) fn squared_length_off_unit(position: &[f32]) -> Option<f32> {
    let &[x, y, z, w, ..] = position else { return None };
    let q = Quat::from_xyzw(x, y, z, w);
    (!math::is_unit(q)).then(|| q.dot(q))
}

/// Fills a slice from its start.
pub(super) fn copy(numbers: impl IntoIterator<Item = f32>, out: &mut [f32]) {
    for (slot, number) in out.iter_mut().zip(numbers) {
        *slot = number;
    }
}

/// An error in the coordinates of a joint.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JointCoordinatesError {
    /// Too few or too many numbers for this kind of joint.
    Count {
        /// Number of values that this kind needs.
        expected: usize,
        /// Number of values that were given.
        found: usize,
    },
    /// A position or a speed is NaN or infinite.
    NonFinite {
        /// Index of the value; the indices of speeds follow those of positions.
        index: usize,
    },
    /// The quaternion is not of length 1.
    NotUnit {
        /// Squared length of the quaternion.
        squared: f32,
    },
    /// The state is too large for f32.
    Overflow,
}

impl fmt::Display for JointCoordinatesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { expected, found } => {
                write!(f, "this kind of joint takes {expected} coordinates, {found} were given")
            }
            Self::NonFinite { index } => write!(f, "joint coordinate {index} is not finite"),
            Self::NotUnit { squared } => {
                write!(
                    f,
                    "the quaternion has squared length {squared}; it must be a unit quaternion"
                )
            }
            Self::Overflow => f.write_str(
                "the joint's state is too large for f32; give angles, lengths and speeds of a machine",
            ),
        }
    }
}

impl core::error::Error for JointCoordinatesError {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_universal_joint_has_the_velocity_and_bias_of_its_rotation() {
        // Central differences of the rotation in single precision, with a suitable step: 1e-2 s.
        let (first, second) = (Vec3::Y, Vec3::new(0.6, 0.0, 0.8));
        let kind = JointKind::Universal { first, second };
        let h = 1e-2;
        let (q, qd) = ([0.3f32, -0.8], [1.1f32, -0.7]);
        let at = |t: f32| {
            let q = [q[0] + qd[0] * t, q[1] + qd[1] * t];
            kind.state(Transform::IDENTITY, &q, &qd).unwrap()
        };
        let (before, now, after) = (at(-h), at(0.0), at(h));
        let turned = math::log(before.pose.rotation.conjugate() * after.pose.rotation) / (2.0 * h);
        // The chord over two steps differs from the tangent by terms of order h².
        assert!((turned - now.velocity.angular).length() < 1e-3, "{turned}");
        let rate = (after.velocity.angular - before.velocity.angular) / (2.0 * h);
        let bias = kind.bias_acceleration(now.pose.rotation, now.velocity).angular;
        assert!((rate - bias).length() < 1e-3, "{rate} {bias}");
    }

    #[test]
    fn bad_coordinates_are_refused() {
        use JointCoordinatesError as E;
        let state = |kind: JointKind, q: &[f32], qd: &[f32]| {
            kind.state(Transform::IDENTITY, q, qd).unwrap_err()
        };
        let elbow = JointKind::Revolute { axis: Vec3::X };
        assert_eq!(state(elbow, &[], &[]), E::Count { expected: 1, found: 0 });
        assert_eq!(state(elbow, &[0.0], &[]), E::Count { expected: 1, found: 0 });
        assert_eq!(state(elbow, &[0.0], &[f32::INFINITY]), E::NonFinite { index: 1 });
        let zero = [0.0; 4];
        assert_eq!(state(JointKind::Spherical, &zero, &[0.0; 3]), E::NotUnit { squared: 0.0 });
    }
}
