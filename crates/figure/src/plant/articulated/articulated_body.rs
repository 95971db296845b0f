//! The articulated inertia of a body and all its descendants, at the body's joint.

use glam::{DMat3, DVec3};

use super::lanes::{Matrices, Vectors};
use super::spatial::{MotionAxis, World, Worlds, skew, skew_times, times_skew_transposed};

/// Equations of motion of a body with all its descendants, at its joint: `torque = A α + B a + torque_bias`,
/// `force = Bᵀ α + M a + force_bias`, with the body's angular acceleration α and its joint's acceleration a.
#[derive(Debug, Clone, Copy)]
pub(super) struct Articulated {
    /// Matrix A of the equations.
    rotational: DMat3,
    /// Matrix B of the equations.
    coupling: DMat3,
    /// Matrix M of the equations.
    mass: DMat3,
    pub(super) torque_bias: DVec3,
    pub(super) force_bias: DVec3,
}

/// The response of a body whose joint turns under its torque: `α = free - dragged a`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Released {
    /// Angular acceleration α if a is zero.
    free: DVec3,
    /// Decrease of α per unit of a: `A⁻¹ B`.
    dragged: DMat3,
    /// Mass of the remaining equation, `force = mass a + force_bias`.
    pub(super) mass: DMat3,
    pub(super) force_bias: DVec3,
}

impl Articulated {
    /// Creates the equations of a body alone: Newton's and Euler's equations about its joint. The mass is in kg,
    /// the first moment in kg m and the rotational inertia in kg m², in body axes.
    #[inline(always)]
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
        }
    }

    /// Lets the joint turn under its torque.
    #[inline(always)]
    pub(super) fn release(&self, torque: DVec3) -> Released {
        let inverse = self.rotational.inverse();
        let free = inverse * (torque - self.torque_bias);
        let dragged = inverse * self.coupling;
        let back = self.coupling.transpose();
        Released {
            free,
            dragged,
            mass: self.mass - back * dragged,
            force_bias: self.force_bias + back * free,
        }
    }

    /// Adds the share of a child.
    #[inline(always)]
    pub(super) fn add(&mut self, share: &Self) {
        self.mass += share.mass;
        self.coupling += share.coupling;
        self.rotational += share.rotational;
        self.force_bias += share.force_bias;
        self.torque_bias += share.torque_bias;
    }

    /// Returns what a child whose joint has bearings adds to its parent's equations: the child transmits the loads on
    /// the bearings, too. `self` are the equations that remain when the joint's dofs are released.
    #[inline(always)]
    pub(super) fn share_of_all(&self, child: &World) -> Self {
        let turned = times_skew_transposed(self.coupling, child.arm_m);
        let coupling = skew_times(child.arm_m, self.mass);
        Self {
            mass: self.mass,
            coupling: self.coupling + coupling,
            rotational: self.rotational
                + turned
                + turned.transpose()
                + times_skew_transposed(coupling, child.arm_m),
            force_bias: self.force_bias,
            torque_bias: self.torque_bias + child.arm_m.cross(self.force_bias),
        }
    }

    /// Returns the torque and force needed for an acceleration.
    #[inline(always)]
    pub(super) fn push(&self, by: MotionAxis) -> MotionAxis {
        MotionAxis {
            angular: self.rotational * by.angular + self.coupling * by.linear,
            linear: self.coupling.transpose() * by.angular + self.mass * by.linear,
        }
    }

    /// Returns the torque and force needed for an acceleration, including `torque_bias` and `force_bias`.
    #[inline(always)]
    pub(super) fn feel(&self, by: MotionAxis) -> MotionAxis {
        let MotionAxis { angular, linear } = self.push(by);
        MotionAxis { angular: angular + self.torque_bias, linear: linear + self.force_bias }
    }

    /// Subtracts the outer product of two columns.
    #[inline(always)]
    pub(super) fn take(&mut self, a: MotionAxis, b: MotionAxis) {
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        self.rotational -= outer(a.angular, b.angular);
        self.coupling -= outer(a.angular, b.linear);
        self.mass -= outer(a.linear, b.linear);
    }
}

impl Released {
    /// Returns what the child adds to its parent's equations: its force at the end of the arm, and the reaction of its
    /// torque.
    #[inline(always)]
    pub(super) fn share(&self, child: &World, torque: DVec3) -> Articulated {
        let Self { mass, force_bias, .. } = *self;
        let force = mass * child.linear_bias_m_s2 + force_bias;
        let coupling = skew_times(child.arm_m, mass);
        Articulated {
            mass,
            coupling,
            rotational: times_skew_transposed(coupling, child.arm_m),
            force_bias: force,
            torque_bias: torque + child.arm_m.cross(force),
        }
    }

    /// Returns the angular acceleration of the body for the linear acceleration of its joint.
    #[inline(always)]
    pub(super) fn follow(&self, linear: DVec3) -> DVec3 {
        self.free - self.dragged * linear
    }
}

/// [`Articulated`] of a body in each mechanism.
#[derive(Debug, Clone, Copy)]
pub(super) struct ArticulatedLanes<const L: usize> {
    rotational: Matrices<L>,
    coupling: Matrices<L>,
    mass: Matrices<L>,
    torque_bias: Vectors<L>,
    force_bias: Vectors<L>,
}

impl<const L: usize> ArticulatedLanes<L> {
    pub(super) const ZERO: Self = Self {
        rotational: Matrices::ZERO,
        coupling: Matrices::ZERO,
        mass: Matrices::ZERO,
        torque_bias: Vectors::ZERO,
        force_bias: Vectors::ZERO,
    };

    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> Articulated {
        Articulated {
            rotational: self.rotational.at(lane),
            coupling: self.coupling.at(lane),
            mass: self.mass.at(lane),
            torque_bias: self.torque_bias.at(lane),
            force_bias: self.force_bias.at(lane),
        }
    }

    /// Releases ball joints under their torques, which are in body axes, and sets what they add to their parents'
    /// equations. All results are arguments: the compiler then knows that they overlap nothing.
    #[inline(always)]
    pub(super) fn release(
        &self,
        out: &mut ReleasedLanes<L>,
        shares: &mut Self,
        worlds: &Worlds<L>,
        torque_nm: &Vectors<L>,
    ) {
        for lane in 0..L {
            let world = worlds.at(lane);
            let torque = world.axes * torque_nm.at(lane);
            let released = self.at(lane).release(torque);
            out.set(lane, &released);
            shares.set(lane, &released.share(&world, torque));
        }
    }

    /// Adds the shares of a child.
    #[inline(always)]
    pub(super) fn add(&mut self, shares: &Self) {
        for lane in 0..L {
            let mut sum = self.at(lane);
            sum.add(&shares.at(lane));
            self.set(lane, &sum);
        }
    }

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, one: &Articulated) {
        self.rotational.set(lane, one.rotational);
        self.coupling.set(lane, one.coupling);
        self.mass.set(lane, one.mass);
        self.torque_bias.set(lane, one.torque_bias);
        self.force_bias.set(lane, one.force_bias);
    }
}

/// The response of a released body in each mechanism: see [`Released`].
#[derive(Debug, Clone, Copy)]
pub(super) struct ReleasedLanes<const L: usize> {
    free: Vectors<L>,
    dragged: Matrices<L>,
}

impl<const L: usize> ReleasedLanes<L> {
    pub(super) const ZERO: Self = Self { free: Vectors::ZERO, dragged: Matrices::ZERO };

    #[inline(always)]
    pub(super) fn set(&mut self, lane: usize, one: &Released) {
        self.free.set(lane, one.free);
        self.dragged.set(lane, one.dragged);
    }

    /// Returns the angular acceleration of the body for the linear acceleration of its joint.
    #[inline(always)]
    pub(super) fn follow(&self, lane: usize, linear: DVec3) -> DVec3 {
        self.free.at(lane) - self.dragged.at(lane) * linear
    }
}
