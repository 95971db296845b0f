//! Motion axes, states of bodies, and matrix operations for all files of this module.

use glam::{DMat3, DQuat, DVec3};

use crate::plant::Pose;

/// Maximum number of dofs of a joint.
pub(super) const MAX_DOFS: usize = 6;

/// The motion along a dof of a joint: the change of the body's velocity per unit speed, world axes.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct MotionAxis {
    pub(super) angular: DVec3,
    pub(super) linear: DVec3,
}

impl MotionAxis {
    #[inline]
    pub(super) fn dot(self, other: Self) -> f64 {
        self.angular.dot(other.angular) + self.linear.dot(other.linear)
    }

    #[inline]
    pub(super) fn plus(self, other: Self, factor: f64) -> Self {
        Self {
            angular: self.angular + other.angular * factor,
            linear: self.linear + other.linear * factor,
        }
    }
}

/// Pose and velocity of a body relative to its parent.
#[derive(Debug, Clone, Copy)]
pub(super) struct InParent {
    pub(super) pose: Pose,
    /// Angular velocity, body axes.
    pub(super) spin_rad_s: DVec3,
    /// Velocity of the origin, in the parent's axes.
    pub(super) slide_m_s: DVec3,
}

/// Rotation and velocities of a body in the world, computed from the joints.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct World {
    pub(super) rotation: DQuat,
    /// Rotation as a matrix.
    pub(super) axes: DMat3,
    /// Vector from the parent's joint to this joint.
    pub(super) arm_m: DVec3,
    pub(super) angular_rad_s: DVec3,
    /// Velocity of the joint relative to the parent's point there.
    pub(super) slide_m_s: DVec3,
    /// Angular acceleration relative to the parent's, if the components of the spin are constant.
    pub(super) angular_bias_rad_s2: DVec3,
    /// Acceleration of the joint relative to the parent's, if the parent's angular velocity is constant.
    pub(super) linear_bias_m_s2: DVec3,
    /// Angular velocity relative to the parent, body axes.
    pub(super) spin_rad_s: DVec3,
}

/// Returns the matrix of `v ×`.
#[inline]
pub(super) fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// Computes `skew(v) m` without the products by zero.
#[inline]
pub(super) fn skew_times(v: DVec3, m: DMat3) -> DMat3 {
    DMat3::from_cols(v.cross(m.x_axis), v.cross(m.y_axis), v.cross(m.z_axis))
}

/// Computes `m skew(v)ᵀ` without the products by zero.
#[inline]
pub(super) fn times_skew_transposed(m: DMat3, v: DVec3) -> DMat3 {
    DMat3::from_cols(
        m.z_axis * v.y - m.y_axis * v.z,
        m.x_axis * v.z - m.z_axis * v.x,
        m.y_axis * v.x - m.x_axis * v.y,
    )
}
