//! Rigid transforms, and motion and force vectors.

use core::ops::{Add, Mul, Sub};

use glam::{Quat, Vec3};

use crate::math;

/// Pose of an inner frame in an outer frame: `p_outer = rotation p_inner + translation_m`.
///
/// ```
/// use sinew_core::{Transform, glam::{Quat, Vec3}};
/// let half_turn = Quat::from_xyzw(0.0, 0.0, 1.0, 0.0);
/// let pose = Transform::new(half_turn, Vec3::new(1.0, 0.0, 0.0));
/// assert_eq!(pose.transform_point(Vec3::X), Vec3::ZERO);
/// assert_eq!(pose * pose.inverse(), Transform::IDENTITY);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Transform {
    /// Unit rotation from the inner to the outer frame.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::unit_rotation"))]
    pub rotation: Quat,
    /// Origin of the inner frame in the outer frame, m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub translation_m: Vec3,
}

impl Transform {
    /// The identity: both frames are the same.
    pub const IDENTITY: Self = Self { rotation: Quat::IDENTITY, translation_m: Vec3::ZERO };

    /// Creates a pose from its parts.
    pub const fn new(rotation: Quat, translation_m: Vec3) -> Self {
        Self { rotation, translation_m }
    }

    /// Creates a pose that only moves the origin.
    pub const fn from_translation(translation_m: Vec3) -> Self {
        Self { rotation: Quat::IDENTITY, translation_m }
    }

    /// Converts a point from the inner frame to the outer frame.
    pub fn transform_point(self, point_m: Vec3) -> Vec3 {
        math::rotate(self.rotation, point_m) + self.translation_m
    }

    /// Returns the pose of the outer frame in the inner frame.
    #[must_use]
    pub fn inverse(self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation_m: -math::rotate(rotation, self.translation_m) }
    }

    /// Returns `true` if every component is finite.
    pub fn is_finite(self) -> bool {
        let of_rotation = self.rotation.dot(Quat::from_xyzw(0.0, 0.0, 0.0, 0.0));
        math::zero_of_numbers(self.translation_m) + of_rotation == 0.0
    }
}

impl Default for Transform {
    fn default() -> Self {
        Self::IDENTITY
    }
}

impl From<Vec3> for Transform {
    /// Creates a pose without rotation from a translation in m.
    fn from(translation_m: Vec3) -> Self {
        Self::from_translation(translation_m)
    }
}

impl Mul for Transform {
    type Output = Self;

    fn mul(self, inner: Self) -> Self {
        Self {
            rotation: self.rotation * inner.rotation,
            translation_m: self.transform_point(inner.translation_m),
        }
    }
}

/// Angular and linear velocity (rad/s, m/s) or acceleration (rad/s², m/s²) of a frame's origin.
///
/// Code that uses a `Twist` states its axes. The linear part is the plain time derivative of the origin's path
/// (classical, not spatial, acceleration).
///
/// ```
/// use sinew_core::{Twist, glam::Vec3, math};
/// let motion = Twist::new(Vec3::X, Vec3::Y * 0.5);
/// // The motion in axes that are rotated by a quarter turn about z.
/// let turned = motion.rotated(math::exp(Vec3::Z * core::f32::consts::FRAC_PI_2));
/// assert!((turned.angular - Vec3::Y).length() < 1e-6);
/// assert!((turned.linear + Vec3::X * 0.5).length() < 1e-6);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Twist {
    /// Angular part, rad/s or rad/s².
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub angular: Vec3,
    /// Linear part, of the frame's origin, m/s or m/s².
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub linear: Vec3,
}

impl Twist {
    /// Zero velocity or acceleration.
    pub const ZERO: Self = Self { angular: Vec3::ZERO, linear: Vec3::ZERO };

    /// Creates a motion from its parts.
    pub const fn new(angular: Vec3, linear: Vec3) -> Self {
        Self { angular, linear }
    }

    /// Returns `true` if every component is finite.
    pub fn is_finite(self) -> bool {
        math::zero_of_numbers(self.angular) + math::zero_of_numbers(self.linear) == 0.0
    }

    /// Returns the motion in rotated axes.
    #[must_use]
    pub fn rotated(self, rotation: Quat) -> Self {
        Self {
            angular: math::rotate(rotation, self.angular),
            linear: math::rotate(rotation, self.linear),
        }
    }
}

impl Add for Twist {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { angular: self.angular + other.angular, linear: self.linear + other.linear }
    }
}

impl Mul<f32> for Twist {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self { angular: self.angular * factor, linear: self.linear * factor }
    }
}

impl Sub for Twist {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { angular: self.angular - other.angular, linear: self.linear - other.linear }
    }
}

/// Force, and its moment about a frame's origin.
///
/// Code that uses a `Wrench` states its axes.
///
/// ```
/// use sinew_core::{Twist, Wrench, glam::Vec3};
/// let wrench = Wrench::new(Vec3::Z * 3.0, Vec3::X * 10.0);
/// // 3 N m at 2 rad/s, and 10 N at 0.5 m/s.
/// let velocity = Twist::new(Vec3::Z * 2.0, Vec3::X * 0.5);
/// assert_eq!(wrench.power_w(velocity), 11.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct Wrench {
    /// Moment about the frame's origin, in N m.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub moment_nm: Vec3,
    /// Force, in N.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub force_n: Vec3,
}

impl Wrench {
    /// Zero force and moment.
    pub const ZERO: Self = Self { moment_nm: Vec3::ZERO, force_n: Vec3::ZERO };

    /// Creates a wrench from its parts.
    pub const fn new(moment_nm: Vec3, force_n: Vec3) -> Self {
        Self { moment_nm, force_n }
    }

    /// Returns `true` if every component is finite.
    pub fn is_finite(self) -> bool {
        self.as_twist().is_finite()
    }

    /// Returns the six numbers as a twist, because both have the same components along a joint's axes.
    pub(crate) fn as_twist(self) -> Twist {
        Twist { angular: self.moment_nm, linear: self.force_n }
    }

    /// Returns the power in W that the wrench gives a body moving with `velocity` (same axes, same origin).
    pub fn power_w(self, velocity: Twist) -> f32 {
        self.moment_nm.dot(velocity.angular) + self.force_n.dot(velocity.linear)
    }
}

impl AsRef<Self> for Wrench {
    fn as_ref(&self) -> &Self {
        self
    }
}

impl AsMut<Self> for Wrench {
    fn as_mut(&mut self) -> &mut Self {
        self
    }
}

impl Add for Wrench {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self { moment_nm: self.moment_nm + other.moment_nm, force_n: self.force_n + other.force_n }
    }
}

impl Sub for Wrench {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self { moment_nm: self.moment_nm - other.moment_nm, force_n: self.force_n - other.force_n }
    }
}
