//! Motion axes, states of bodies, and matrix operations for all files of this module.

use glam::{DMat3, DQuat, DVec3};

use super::lanes::{Matrices, Rotations, Vectors};
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
    #[inline(always)]
    pub(super) fn dot(self, other: Self) -> f64 {
        self.angular.dot(other.angular) + self.linear.dot(other.linear)
    }

    #[inline(always)]
    pub(super) fn plus(self, other: Self, factor: f64) -> Self {
        Self {
            angular: self.angular + other.angular * factor,
            linear: self.linear + other.linear * factor,
        }
    }
}

/// [`MotionAxis`] of each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct Motions<const L: usize> {
    angular: Vectors<L>,
    linear: Vectors<L>,
}

impl<const L: usize> Motions<L> {
    pub(super) const ZERO: Self = Self { angular: Vectors::ZERO, linear: Vectors::ZERO };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> MotionAxis {
        MotionAxis { angular: self.angular.at(lane), linear: self.linear.at(lane) }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, one: MotionAxis) {
        self.angular.set(lane, one.angular);
        self.linear.set(lane, one.linear);
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
}

/// [`InParent`] of a body in each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct InParents<const L: usize> {
    pub(super) rotation: Rotations<L>,
    pub(super) position_m: Vectors<L>,
    pub(super) spin_rad_s: Vectors<L>,
    pub(super) slide_m_s: Vectors<L>,
}

impl<const L: usize> InParents<L> {
    pub(super) const STILL: Self = Self {
        rotation: Rotations::IDENTITY,
        position_m: Vectors::ZERO,
        spin_rad_s: Vectors::ZERO,
        slide_m_s: Vectors::ZERO,
    };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> InParent {
        InParent {
            pose: Pose { rotation: self.rotation.at(lane), position_m: self.position_m.at(lane) },
            spin_rad_s: self.spin_rad_s.at(lane),
            slide_m_s: self.slide_m_s.at(lane),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, one: &InParent) {
        self.rotation.set(lane, one.pose.rotation);
        self.position_m.set(lane, one.pose.position_m);
        self.spin_rad_s.set(lane, one.spin_rad_s);
        self.slide_m_s.set(lane, one.slide_m_s);
    }
}

/// [`World`] of a body in each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct Worlds<const L: usize> {
    pub(super) rotation: Rotations<L>,
    pub(super) axes: Matrices<L>,
    pub(super) arm_m: Vectors<L>,
    angular_rad_s: Vectors<L>,
    slide_m_s: Vectors<L>,
    angular_bias_rad_s2: Vectors<L>,
    linear_bias_m_s2: Vectors<L>,
}

impl<const L: usize> Worlds<L> {
    pub(super) const STILL: Self = Self {
        rotation: Rotations::IDENTITY,
        axes: Matrices::ZERO,
        arm_m: Vectors::ZERO,
        angular_rad_s: Vectors::ZERO,
        slide_m_s: Vectors::ZERO,
        angular_bias_rad_s2: Vectors::ZERO,
        linear_bias_m_s2: Vectors::ZERO,
    };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> World {
        World {
            rotation: self.rotation.at(lane),
            axes: self.axes.at(lane),
            arm_m: self.arm_m.at(lane),
            angular_rad_s: self.angular_rad_s.at(lane),
            slide_m_s: self.slide_m_s.at(lane),
            angular_bias_rad_s2: self.angular_bias_rad_s2.at(lane),
            linear_bias_m_s2: self.linear_bias_m_s2.at(lane),
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, one: &World) {
        self.rotation.set(lane, one.rotation);
        self.axes.set(lane, one.axes);
        self.arm_m.set(lane, one.arm_m);
        self.angular_rad_s.set(lane, one.angular_rad_s);
        self.slide_m_s.set(lane, one.slide_m_s);
        self.angular_bias_rad_s2.set(lane, one.angular_bias_rad_s2);
        self.linear_bias_m_s2.set(lane, one.linear_bias_m_s2);
    }
}

/// Returns the matrix of `v ×`.
#[inline(always)]
pub(super) fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}

/// Computes `skew(v) m` without the products by zero.
#[inline(always)]
pub(super) fn skew_times(v: DVec3, m: DMat3) -> DMat3 {
    DMat3::from_cols(v.cross(m.x_axis), v.cross(m.y_axis), v.cross(m.z_axis))
}

/// Computes `m skew(v)ᵀ` without the products by zero.
#[inline(always)]
pub(super) fn times_skew_transposed(m: DMat3, v: DVec3) -> DMat3 {
    DMat3::from_cols(
        m.z_axis * v.y - m.y_axis * v.z,
        m.x_axis * v.z - m.z_axis * v.x,
        m.y_axis * v.x - m.x_axis * v.y,
    )
}
