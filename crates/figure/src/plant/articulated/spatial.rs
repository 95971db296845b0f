//! Motion axes, states of bodies and matrices that all files here compute with.

use glam::{DMat3, DQuat, DVec3};

use crate::plant::Pose;

/// The largest number of degrees of freedom of a joint.
pub(super) const MAX_DOFS: usize = 6;

/// The motion along a dof of a joint: what its unit speed adds to the body's velocity, world axes.
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

/// A pose and a velocity of a body in its parent.
#[derive(Debug, Clone, Copy)]
pub(super) struct InParent {
    pub(super) pose: Pose,
    /// Body axes.
    pub(super) spin_rad_s: DVec3,
    /// Of the origin, the parent's axes.
    pub(super) slide_m_s: DVec3,
}

/// A rotation and velocities of a body, world axes: what follows from the joints.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct World {
    pub(super) rotation: DQuat,
    /// The rotation as a matrix.
    pub(super) axes: DMat3,
    /// From the parent's joint to this one.
    pub(super) arm_m: DVec3,
    pub(super) angular_rad_s: DVec3,
    /// Velocity of the joint less that of the parent there.
    pub(super) slide_m_s: DVec3,
    /// Angular acceleration less the parent's, if the components of the spin stay.
    pub(super) angular_bias_rad_s2: DVec3,
    /// Acceleration of the joint less the parent's, if the parent turns steadily.
    pub(super) linear_bias_m_s2: DVec3,
    /// Angular velocity against the parent, body axes.
    pub(super) spin_rad_s: DVec3,
}

/// The matrix of `v ×`.
#[inline]
pub(super) fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// `skew(v) m`, without the products by zero.
#[inline]
pub(super) fn skew_times(v: DVec3, m: DMat3) -> DMat3 {
    DMat3::from_cols(v.cross(m.x_axis), v.cross(m.y_axis), v.cross(m.z_axis))
}

/// `m skew(v)ᵀ`, without the products by zero.
#[inline]
pub(super) fn times_skew_transposed(m: DMat3, v: DVec3) -> DMat3 {
    DMat3::from_cols(
        m.z_axis * v.y - m.y_axis * v.z,
        m.x_axis * v.z - m.z_axis * v.x,
        m.y_axis * v.x - m.x_axis * v.y,
    )
}
