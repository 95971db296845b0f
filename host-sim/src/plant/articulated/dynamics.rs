//! Forward dynamics by the articulated-body algorithm (Featherstone, Rigid Body Dynamics Algorithms, 2008,
//! chapter 7), O(n), made for spherical joints.
//!
//! All is in world axes, each body about its own joint. A drive acts on all three turns of a spherical joint,
//! so a subtree passes nothing on to its parent but a force at the joint, and the inertia that the parent
//! feels there is a 3x3 matrix: nothing is turned from body to body, and there are no 6x6 matrices.
//! Accelerations are the classical ones of the joints, so no linear velocity enters.

use glam::{DMat3, DVec3};

use super::tree::{Link, Tree, World};
use crate::plant::Root;

/// A body with all that hangs on it, as felt at its joint:
/// `torque = A α + B a + torque_bias`, `force = Bᵀ α + M a + force_bias`,
/// with the body's angular acceleration α and its joint's acceleration a.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Articulated {
    /// A.
    rotational: DMat3,
    /// B.
    coupling: DMat3,
    /// M.
    mass: DMat3,
    torque_bias: DVec3,
    force_bias: DVec3,
    /// α if a is zero.
    free: DVec3,
    /// What a takes from α: `A⁻¹ B`.
    dragged: DMat3,
    /// α.
    angular: DVec3,
    /// a, less gravity.
    linear: DVec3,
}

impl Tree {
    /// Works out the accelerations that the drives make.
    pub(super) fn accelerate(&mut self) {
        for link in &mut self.links {
            link.articulated = link.alone();
        }
        for index in (1..self.links.len()).rev() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let torque = link.world.axes * link.torque_nm;
            let (mass, force_bias) = link.articulated.release(torque);
            if let Some(parent) = link.parent {
                above[parent].articulated.carry(&link.world, mass, force_bias, torque);
            }
        }
        self.accelerate_root();
        for index in 1..self.links.len() {
            let (above, below) = self.links.split_at_mut(index);
            let link = &mut below[0];
            let World { axes, arm_m, angular_bias_rad_s2, linear_bias_m_s2, .. } = link.world;
            if let Some(parent) = link.parent {
                let parent = &above[parent].articulated;
                let linear = parent.linear + parent.angular.cross(arm_m) + linear_bias_m_s2;
                link.articulated.follow(linear);
                let relative = link.articulated.angular - parent.angular - angular_bias_rad_s2;
                link.spin_rate_rad_s2 = axes.transpose() * relative;
            }
        }
    }

    /// Gravity is an acceleration of the world upwards.
    fn accelerate_root(&mut self) {
        let root = &mut self.links[0];
        let axes = root.world.axes;
        match self.root {
            Root::Fixed => root.articulated.linear = -self.gravity_m_s2,
            Root::Driven => {
                let (mass, force_bias) = root.articulated.release(axes * root.torque_nm);
                let linear = mass.inverse() * (axes * self.root_force_n - force_bias);
                root.articulated.follow(linear);
            }
        }
        root.spin_rate_rad_s2 = axes.transpose() * root.articulated.angular;
        self.root_acceleration_m_s2 = root.articulated.linear + self.gravity_m_s2;
    }
}

impl Link {
    /// The body by itself: Newton's and Euler's equations about the joint.
    fn alone(&self) -> Articulated {
        let World { axes, angular_rad_s: angular, .. } = self.world;
        let rotational = axes * self.rotational_kg_m2 * axes.transpose();
        let first_moment = axes * self.first_moment_kg_m;
        Articulated {
            rotational,
            coupling: skew(first_moment),
            mass: DMat3::from_diagonal(DVec3::splat(self.mass_kg)),
            torque_bias: angular.cross(rotational * angular),
            force_bias: angular.cross(angular.cross(first_moment)),
            ..Articulated::default()
        }
    }
}

impl Articulated {
    /// Lets the joint turn under its torque. What is left is `force = mass a + force_bias`, returned.
    fn release(&mut self, torque: DVec3) -> (DMat3, DVec3) {
        let inverse = self.rotational.inverse();
        self.free = inverse * (torque - self.torque_bias);
        self.dragged = inverse * self.coupling;
        let back = self.coupling.transpose();
        (self.mass - back * self.dragged, self.force_bias + back * self.free)
    }

    /// Adds a released child: its force at the end of the arm, and the reaction of its torque.
    fn carry(&mut self, child: &World, mass: DMat3, force_bias: DVec3, torque: DVec3) {
        let arm = skew(child.arm_m);
        let force = mass * child.linear_bias_m_s2 + force_bias;
        let coupling = arm * mass;
        self.mass += mass;
        self.coupling += coupling;
        self.rotational += coupling * arm.transpose();
        self.force_bias += force;
        self.torque_bias += torque + child.arm_m.cross(force);
    }

    /// Moves a released body with its joint.
    fn follow(&mut self, linear: DVec3) {
        self.linear = linear;
        self.angular = self.free - self.dragged * linear;
    }
}

/// The matrix of `v ×`.
pub(super) fn skew(v: DVec3) -> DMat3 {
    DMat3::from_cols(
        DVec3::new(0.0, v.z, -v.y),
        DVec3::new(-v.z, 0.0, v.x),
        DVec3::new(v.y, -v.x, 0.0),
    )
}
