//! Joint models of 0 to 6 dofs and their motion subspaces.

use core::fmt;

use glam::{Quat, Vec3};
use heapless::Vec;

use crate::math::{self, UNIT_TOLERANCE};
use crate::transform::{Transform, Twist, Wrench};

/// The motions that a joint allows. Axes are unit vectors. The joint frame is the parent's frame after the placement
/// of the joint (see [`Body`](crate::Body)).
///
/// The motion subspace S (6 x dofs, body axes) of each kind has orthonormal columns: S Sᵀ projects on it. For that
/// reason a universal joint's axes must be perpendicular.
///
/// ```
/// use sinew_core::{JointKind, glam::Vec3};
/// let knee = JointKind::Revolute { axis: Vec3::X };
/// assert_eq!(knee.dof_count(), 1);
/// // A quaternion has four coordinates for three dofs.
/// assert_eq!(JointKind::Spherical.dof_count(), 3);
/// assert_eq!(JointKind::Spherical.coordinate_count(), 4);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case", deny_unknown_fields)
)]
pub enum JointKind {
    /// 0 dofs: rigid.
    Fixed,
    /// 1 dof: rotation about an axis, the same in the joint and the body frame.
    Revolute {
        /// Axis of rotation, a unit vector.
        #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::unit_axis"))]
        axis: Vec3,
    },
    /// 1 dof: displacement along an axis, the same in the joint and the body frame.
    Prismatic {
        /// Axis of displacement, a unit vector.
        #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::unit_axis"))]
        axis: Vec3,
    },
    /// 2 dofs: rotation about `first`, fixed in the joint frame, then about `second`, fixed in the body.
    Universal {
        /// Unit axis in the joint frame.
        #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::unit_axis"))]
        first: Vec3,
        /// Unit axis in the body frame, perpendicular to `first`.
        #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::unit_axis"))]
        second: Vec3,
    },
    /// 3 dofs: any rotation.
    Spherical,
    /// 6 dofs: any motion. Use it for a floating root.
    Free,
}

impl JointKind {
    /// Returns the number of dofs, 0 to 6.
    pub const fn dof_count(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute { .. } | Self::Prismatic { .. } => 1,
            Self::Universal { .. } => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }

    /// Returns `true` if the joint can translate, so that its drive may exert a force.
    #[inline]
    pub(crate) const fn slides(self) -> bool {
        matches!(self, Self::Prismatic { .. } | Self::Free)
    }

    /// Returns the number of coordinates of [`Self::state`]: a quaternion has four for three dofs.
    pub const fn coordinate_count(self) -> usize {
        match self {
            Self::Spherical => 4,
            Self::Free => 7,
            other => other.dof_count(),
        }
    }

    /// Returns the columns of the motion subspace S in body axes. `rotation` is the body's rotation in the joint
    /// frame.
    ///
    /// ```
    /// use sinew_core::{JointKind, glam::{Quat, Vec3}};
    /// let elbow = JointKind::Revolute { axis: Vec3::X };
    /// assert_eq!(elbow.motion_subspace(Quat::IDENTITY)[0].angular, Vec3::X);
    /// ```
    pub fn motion_subspace(self, rotation: Quat) -> Vec<Twist, 6> {
        let turn = |axis| Twist::new(axis, Vec3::ZERO);
        let slide = |axis| Twist::new(Vec3::ZERO, axis);
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        match self {
            Self::Fixed => Vec::new(),
            Self::Revolute { axis } => [turn(axis)].into_iter().collect(),
            Self::Prismatic { axis } => [slide(axis)].into_iter().collect(),
            Self::Universal { first, second } => {
                [turn(math::rotate(rotation.conjugate(), first)), turn(second)]
                    .into_iter()
                    .collect()
            }
            Self::Spherical => axes.map(turn).into_iter().collect(),
            Self::Free => axes.map(turn).into_iter().chain(axes.map(slide)).collect(),
        }
    }

    /// Returns S Sᵀ times `motion`: the part of a motion that the joint allows, in body axes.
    ///
    /// ```
    /// use sinew_core::{JointKind, Twist, glam::{Quat, Vec3}};
    /// let knee = JointKind::Revolute { axis: Vec3::X };
    /// let wanted = Twist::new(Vec3::new(3.0, 4.0, 0.0), Vec3::Z);
    /// let possible = knee.project_twist(Quat::IDENTITY, wanted);
    /// assert_eq!(possible, Twist::new(Vec3::new(3.0, 0.0, 0.0), Vec3::ZERO));
    /// ```
    #[inline]
    pub fn project_twist(self, rotation: Quat, motion: Twist) -> Twist {
        match self {
            Self::Free => motion,
            Self::Spherical => Twist { linear: Vec3::ZERO, ..motion },
            _ => {
                let (angular, linear) = self.on_axes(rotation, motion.angular, motion.linear);
                Twist { angular, linear }
            }
        }
    }

    /// Returns S Sᵀ times `wrench`: the part that the joint's drive must deliver; the bearings carry the rest. Both are
    /// in body axes.
    ///
    /// ```
    /// use sinew_core::{JointKind, Wrench, glam::{Quat, Vec3}};
    /// let knee = JointKind::Revolute { axis: Vec3::X };
    /// let at_joint = Wrench::new(Vec3::new(3.0, 4.0, 0.0), Vec3::Y * -100.0);
    /// let of_drive = knee.project_wrench(Quat::IDENTITY, at_joint);
    /// assert_eq!(of_drive, Wrench::new(Vec3::new(3.0, 0.0, 0.0), Vec3::ZERO));
    /// ```
    #[inline]
    pub fn project_wrench(self, rotation: Quat, wrench: Wrench) -> Wrench {
        match self {
            Self::Free => wrench,
            Self::Spherical => Wrench { force_n: Vec3::ZERO, ..wrench },
            Self::Revolute { axis } => Wrench::new(axis * axis.dot(wrench.moment_nm), Vec3::ZERO),
            _ => {
                let (moment_nm, force_n) = self.on_axes(rotation, wrench.moment_nm, wrench.force_n);
                Wrench { moment_nm, force_n }
            }
        }
    }

    /// Returns the part of a vector pair that a joint allows. The callers handle spherical and free joints themselves,
    /// because most joints of a figure are spherical.
    pub(crate) fn on_axes(self, rotation: Quat, angular: Vec3, linear: Vec3) -> (Vec3, Vec3) {
        match self {
            Self::Fixed => (Vec3::ZERO, Vec3::ZERO),
            Self::Revolute { axis } => (axis * axis.dot(angular), Vec3::ZERO),
            Self::Prismatic { axis } => (Vec3::ZERO, axis * axis.dot(linear)),
            Self::Universal { first, second } => {
                let first = math::rotate(rotation.conjugate(), first);
                (first * first.dot(angular) + second * second.dot(angular), Vec3::ZERO)
            }
            Self::Spherical => (angular, Vec3::ZERO),
            Self::Free => (angular, linear),
        }
    }

    /// Returns the joint's acceleration at constant speed of its axes (Ṡ q̇), in body axes. It is nonzero only for a
    /// universal joint, whose first axis moves in the body.
    ///
    /// ```
    /// use sinew_core::{JointKind, Twist, glam::{Quat, Vec3}};
    /// // First axis 2 rad/s, second axis 3 rad/s: the second rotates the first axis within the body.
    /// let wrist = JointKind::Universal { first: Vec3::X, second: Vec3::Y };
    /// let velocity = Twist::new(Vec3::new(2.0, 3.0, 0.0), Vec3::ZERO);
    /// let bias = wrist.bias_acceleration(Quat::IDENTITY, velocity);
    /// assert_eq!(bias, Twist::new(Vec3::Z * 6.0, Vec3::ZERO));
    /// ```
    #[inline]
    pub fn bias_acceleration(self, rotation: Quat, velocity: Twist) -> Twist {
        match self {
            Self::Universal { first, second } => {
                let first = math::rotate(rotation.conjugate(), first);
                let speeds = first.dot(velocity.angular) * second.dot(velocity.angular);
                Twist::new(first.cross(second) * speeds, Vec3::ZERO)
            }
            _ => Twist::ZERO,
        }
    }

    /// Returns angles in rad or displacement in m along the axes of a joint with one or two axes, for the valid pose
    /// nearest to `in_joint`. Returns zeros for other kinds of joints.
    ///
    /// Angles are in [-π, π].
    pub(crate) fn along(self, in_joint: &Transform) -> [f32; 2] {
        match self {
            Self::Revolute { axis } => [math::turn_about(axis, in_joint.rotation), 0.0],
            Self::Prismatic { axis } => [axis.dot(in_joint.translation_m), 0.0],
            Self::Universal { first, second } => {
                let turned = math::rotate(in_joint.rotation, second);
                let angle = math::atan2(first.cross(second).dot(turned), second.dot(turned));
                let rest = math::exp(first * -angle) * in_joint.rotation;
                [angle, math::turn_about(second, rest)]
            }
            Self::Fixed | Self::Spherical | Self::Free => [0.0; 2],
        }
    }

    /// Returns the pose, in the joint frame, of a joint with one or two axes; the identity for the other kinds.
    pub(crate) fn at(self, along: [f32; 2]) -> Transform {
        let [a, b] = along;
        let turned = |rotation| Transform::new(rotation, Vec3::ZERO);
        match self {
            Self::Revolute { axis } => turned(math::exp(axis * a)),
            Self::Prismatic { axis } => Transform::from_translation(axis * a),
            Self::Universal { first, second } => {
                turned(math::unit(math::exp(first * a) * math::exp(second * b)))
            }
            Self::Fixed | Self::Spherical | Self::Free => Transform::IDENTITY,
        }
    }

    /// Refuses axes that are not finite, not unit, or (universal) not perpendicular.
    ///
    /// # Errors
    /// [`JointError`] with the wrong value.
    pub fn validate(self) -> Result<(), JointError> {
        let check = |axis: Vec3| {
            let length = math::length(axis);
            if !axis.is_finite() {
                Err(JointError::NonFiniteAxis)
            } else if (length - 1.0).abs() > UNIT_TOLERANCE {
                Err(JointError::AxisNotUnit { length })
            } else {
                Ok(())
            }
        };
        match self {
            Self::Revolute { axis } | Self::Prismatic { axis } => check(axis),
            Self::Universal { first, second } => {
                check(first)?;
                check(second)?;
                let cosine = first.dot(second);
                if cosine.abs() > UNIT_TOLERANCE {
                    return Err(JointError::AxesNotPerpendicular { cosine });
                }
                Ok(())
            }
            Self::Fixed | Self::Spherical | Self::Free => Ok(()),
        }
    }

    /// Returns the joint with axes of unit length, exact within f32, and a universal joint's second axis
    /// perpendicular to the first. The axes must have passed [`Self::validate`].
    #[must_use]
    pub(crate) fn normalized(self) -> Self {
        let unit = |axis: Vec3| axis * (1.0 / math::length(axis));
        match self {
            Self::Revolute { axis } => Self::Revolute { axis: unit(axis) },
            Self::Prismatic { axis } => Self::Prismatic { axis: unit(axis) },
            Self::Universal { first, second } => {
                let first = unit(first);
                Self::Universal { first, second: unit(second - first * first.dot(second)) }
            }
            other => other,
        }
    }
}

/// An error in a joint model.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum JointError {
    /// An axis has a NaN or infinite component.
    NonFiniteAxis,
    /// An axis is not of length 1.
    AxisNotUnit {
        /// Length of the axis.
        length: f32,
    },
    /// The two axes of a universal joint are not at a right angle.
    AxesNotPerpendicular {
        /// Cosine of the angle between the axes.
        cosine: f32,
    },
}

impl fmt::Display for JointError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NonFiniteAxis => f.write_str("a joint axis is not finite"),
            Self::AxisNotUnit { length } => {
                write!(f, "a joint axis has length {length}; it must be a unit vector")
            }
            Self::AxesNotPerpendicular { cosine } => write!(
                f,
                "the axes of a universal joint must be perpendicular; the cosine between them is {cosine}"
            ),
        }
    }
}

impl core::error::Error for JointError {}

#[cfg(test)]
mod tests {
    use super::*;

    fn kinds() -> [JointKind; 6] {
        let (axis, first) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(0.0, 1.0, 0.0));
        [
            JointKind::Fixed,
            JointKind::Revolute { axis },
            JointKind::Prismatic { axis },
            JointKind::Universal { first, second: axis },
            JointKind::Spherical,
            JointKind::Free,
        ]
    }

    #[test]
    fn projection_is_the_subspace_times_its_transpose() {
        let rotation = math::exp(Vec3::new(0.4, -1.1, 0.3));
        let motion = Twist::new(Vec3::new(1.0, 2.0, -3.0), Vec3::new(-0.5, 0.7, 0.2));
        for kind in kinds() {
            let columns = kind.motion_subspace(rotation);
            assert_eq!(columns.len(), kind.dof_count());
            let mut expected = Twist::ZERO;
            for c in &columns {
                let along = c.angular.dot(motion.angular) + c.linear.dot(motion.linear);
                expected = expected + Twist::new(c.angular * along, c.linear * along);
            }
            let got = kind.project_twist(rotation, motion);
            assert!((got.angular - expected.angular).length() < 1e-6, "{kind:?}");
            assert!((got.linear - expected.linear).length() < 1e-6, "{kind:?}");
        }
    }

    #[test]
    fn bad_axes_are_refused() {
        let nan = JointKind::Revolute { axis: Vec3::new(f32::NAN, 0.0, 0.0) };
        assert_eq!(nan.validate(), Err(JointError::NonFiniteAxis));
        let long = JointKind::Prismatic { axis: Vec3::X * 2.0 };
        assert_eq!(long.validate(), Err(JointError::AxisNotUnit { length: 2.0 }));
        let skew = JointKind::Universal { first: Vec3::X, second: Vec3::X };
        assert_eq!(skew.validate(), Err(JointError::AxesNotPerpendicular { cosine: 1.0 }));
    }
}
