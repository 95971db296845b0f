//! The articulated inertia of a body and all its descendants, at the body's joint.

use glam::{DMat3, DVec3};

use super::spatial::{MotionAxis, World, skew, skew_times, times_skew_transposed};

/// Equations of motion of a body with all its descendants, at its joint: `torque = A α + B a + torque_bias`,
/// `force = Bᵀ α + M a + force_bias`, with the body's angular acceleration α and its joint's acceleration a.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Articulated {
    /// Matrix A of the equations.
    rotational: DMat3,
    /// Matrix B of the equations.
    coupling: DMat3,
    /// Matrix M of the equations.
    mass: DMat3,
    pub(super) torque_bias: DVec3,
    pub(super) force_bias: DVec3,
    /// Angular acceleration α if a is zero.
    free: DVec3,
    /// Decrease of α per unit of a: `A⁻¹ B`.
    dragged: DMat3,
    /// Angular acceleration α.
    pub(super) angular: DVec3,
    /// Acceleration a of the joint, minus gravity.
    pub(super) linear: DVec3,
}

impl Articulated {
    /// Creates the equations of a body alone: Newton's and Euler's equations about its joint. The mass is in kg,
    /// the first moment in kg m and the rotational inertia in kg m², in body axes.
    #[inline]
    pub(super) fn of_body(
        world: &World,
        mass_kg: f64,
        first_moment_kg_m: DVec3,
        rotational_kg_m2: DMat3,
    ) -> Self {
        let World { axes, angular_rad_s: angular, .. } = *world;
        let rotational = axes * rotational_kg_m2 * axes.transpose();
        let first_moment = axes * first_moment_kg_m;
        Self {
            rotational,
            coupling: skew(first_moment),
            mass: DMat3::from_diagonal(DVec3::splat(mass_kg)),
            torque_bias: angular.cross(rotational * angular),
            force_bias: angular.cross(angular.cross(first_moment)),
            ..Self::default()
        }
    }

    /// Lets the joint turn under its torque. The remaining equation is `force = mass a + force_bias`; its mass and
    /// force bias are returned.
    #[inline]
    pub(super) fn release(&mut self, torque: DVec3) -> (DMat3, DVec3) {
        let inverse = self.rotational.inverse();
        self.free = inverse * (torque - self.torque_bias);
        self.dragged = inverse * self.coupling;
        let back = self.coupling.transpose();
        (self.mass - back * self.dragged, self.force_bias + back * self.free)
    }

    /// Adds a released child: its force at the end of the arm, and the reaction of its torque.
    #[inline]
    pub(super) fn carry(&mut self, child: &World, mass: DMat3, force_bias: DVec3, torque: DVec3) {
        let force = mass * child.linear_bias_m_s2 + force_bias;
        let coupling = skew_times(child.arm_m, mass);
        self.mass += mass;
        self.coupling += coupling;
        self.rotational += times_skew_transposed(coupling, child.arm_m);
        self.force_bias += force;
        self.torque_bias += torque + child.arm_m.cross(force);
    }

    /// Adds a child whose joint has bearings: the child transmits the loads on the bearings, too.
    #[inline]
    pub(super) fn carry_all(&mut self, child: &World, passed: &Self) {
        let turned = times_skew_transposed(passed.coupling, child.arm_m);
        let coupling = skew_times(child.arm_m, passed.mass);
        self.mass += passed.mass;
        self.coupling += passed.coupling + coupling;
        self.rotational += passed.rotational
            + turned
            + turned.transpose()
            + times_skew_transposed(coupling, child.arm_m);
        self.force_bias += passed.force_bias;
        self.torque_bias += passed.torque_bias + child.arm_m.cross(passed.force_bias);
    }

    /// Computes the angular acceleration of a released body from the linear acceleration of its joint.
    #[inline]
    pub(super) fn follow(&mut self, linear: DVec3) {
        self.linear = linear;
        self.angular = self.free - self.dragged * linear;
    }

    /// Returns the torque and force needed for an acceleration.
    #[inline]
    pub(super) fn push(&self, by: MotionAxis) -> MotionAxis {
        MotionAxis {
            angular: self.rotational * by.angular + self.coupling * by.linear,
            linear: self.coupling.transpose() * by.angular + self.mass * by.linear,
        }
    }

    /// Returns the torque and force needed for an acceleration, including `torque_bias` and `force_bias`.
    #[inline]
    pub(super) fn feel(&self, by: MotionAxis) -> MotionAxis {
        let MotionAxis { angular, linear } = self.push(by);
        MotionAxis { angular: angular + self.torque_bias, linear: linear + self.force_bias }
    }

    /// Subtracts the outer product of two columns.
    #[inline]
    pub(super) fn take(&mut self, a: MotionAxis, b: MotionAxis) {
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        self.rotational -= outer(a.angular, b.angular);
        self.coupling -= outer(a.angular, b.linear);
        self.mass -= outer(a.linear, b.linear);
    }
}
