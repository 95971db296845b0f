//! Joint coordinates, as servos and encoders give them: their state, and what is refused.

use core::fmt;

use glam::{Quat, Vec3};

use crate::joint::JointKind;
use crate::math;
use crate::state::JointState;
use crate::transform::{Transform, Twist};

impl JointKind {
    /// State of a joint from its coordinates, as servos and encoders give them.
    ///
    /// `position`: nothing (fixed), angle in rad (revolute), m (prismatic), two angles (universal), a unit
    /// quaternion xyzw (spherical), a quaternion then x y z in m (free). `speed`: rad/s or m/s along the
    /// columns of the motion subspace. `placement`: of the joint frame in the parent's frame.
    ///
    /// # Errors
    /// [`JointCoordinatesError`] if a count is wrong, a number is not finite or a quaternion not unit, or the state is too
    /// large for f32.
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
        let count = E::Count { expected: self.coordinate_count(), found: position.len() };
        let unit = |q: Quat| {
            if math::is_unit(q) { Ok(math::unit(q)) } else { Err(E::NotUnit { squared: q.dot(q) }) }
        };
        let in_joint = match (self, position) {
            (Self::Fixed, []) => Transform::IDENTITY,
            (Self::Revolute { .. } | Self::Prismatic { .. }, &[a]) => self.at([a, 0.0]),
            (Self::Universal { .. }, &[a, b]) => self.at([a, b]),
            (Self::Spherical, &[x, y, z, w]) => {
                Transform::new(unit(Quat::from_xyzw(x, y, z, w))?, Vec3::ZERO)
            }
            (Self::Free, &[x, y, z, w, tx, ty, tz]) => {
                Transform::new(unit(Quat::from_xyzw(x, y, z, w))?, Vec3::new(tx, ty, tz))
            }
            _ => return Err(count),
        };
        if speed.len() != self.degrees_of_freedom() {
            return Err(E::Count { expected: self.degrees_of_freedom(), found: speed.len() });
        }
        let mut velocity = Twist::ZERO;
        for (column, speed) in self.motion_subspace(in_joint.rotation).iter().zip(speed) {
            velocity = velocity + Twist::new(column.angular * *speed, column.linear * *speed);
        }
        let pose = placement * in_joint;
        if !(pose.is_finite() && velocity.is_finite()) {
            return Err(E::Overflow);
        }
        Ok(JointState { pose, velocity })
    }
}

/// Why joint coordinates were refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JointCoordinatesError {
    /// Too few or too many numbers for this kind of joint.
    Count {
        /// How many this kind takes.
        expected: usize,
        /// How many came.
        found: usize,
    },
    /// A position (or, counted on after them, a speed) is NaN or infinite.
    NonFinite {
        /// Which one.
        index: usize,
    },
    /// The quaternion is not of length 1.
    NotUnit {
        /// Its squared length.
        squared: f32,
    },
    /// The state that the coordinates make is too large for f32.
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
        // Central differences of the rotation in f64-free arithmetic: step chosen for f32, 1e-2 s.
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
