//! The inertia of a body, or of bodies on joints, as one symmetric 6 x 6 matrix.

use glam::{Mat3, Vec3};

use crate::inertia::Inertia;
use crate::matrix::{cross_matrix, outer};
use crate::transform::{Twist, Wrench};

/// Share of an inertia that is rounding, after a few differences.
const ROUNDING: f32 = 1e-6;

/// Wrench per acceleration of a body, both at its origin and in one frame's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SpatialInertia {
    /// Moment per angular acceleration.
    pub(crate) angular: Mat3,
    /// Moment per linear acceleration; its transpose is force per angular acceleration.
    pub(crate) coupling: Mat3,
    /// Force per linear acceleration.
    pub(crate) linear: Mat3,
}

impl SpatialInertia {
    /// Of a body, in its axes.
    pub(crate) fn of(inertia: &Inertia) -> Self {
        let i = &inertia.rotational_kg_m2;
        let about_center = Mat3::from_cols(
            Vec3::new(i.xx, i.xy, i.xz),
            Vec3::new(i.xy, i.yy, i.yz),
            Vec3::new(i.xz, i.yz, i.zz),
        );
        let arm = cross_matrix(inertia.center_of_mass_m);
        let coupling = arm * inertia.mass_kg;
        Self {
            angular: about_center - coupling * arm,
            coupling,
            linear: Mat3::from_diagonal(Vec3::splat(inertia.mass_kg)),
        }
    }

    pub(crate) fn wrench(&self, acceleration: Twist) -> Wrench {
        Wrench {
            moment_nm: self.angular * acceleration.angular + self.coupling * acceleration.linear,
            force_n: self.coupling.transpose() * acceleration.angular
                + self.linear * acceleration.linear,
        }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            angular: self.angular + other.angular,
            coupling: self.coupling + other.coupling,
            linear: self.linear + other.linear,
        }
    }

    /// What is left of it if a joint gives way along its freedoms, each against a rotor: one after the other is
    /// eliminated.
    pub(crate) fn without(mut self, freedoms: &[Twist], rotor: f32) -> Self {
        let whole = self;
        for freedom in freedoms {
            let wrench = self.wrench(*freedom);
            let resistance = wrench.power_w(*freedom) + rotor;
            // What the freedoms before have taken away but for rounding has no direction left.
            if resistance > ROUNDING * whole.wrench(*freedom).power_w(*freedom) {
                self = self.without_one(wrench, 1.0 / resistance);
            }
        }
        self
    }

    /// What is left if a freedom gives way, from its wrench per acceleration, and the acceleration along it
    /// per force along it.
    fn without_one(&self, wrench: Wrench, share: f32) -> Self {
        let (moment, force) = (wrench.moment_nm * share, wrench.force_n * share);
        Self {
            angular: self.angular - outer(moment, wrench.moment_nm),
            coupling: self.coupling - outer(moment, wrench.force_n),
            linear: self.linear - outer(force, wrench.force_n),
        }
    }

    /// The same at another origin that this one is `arm_m` away from.
    pub(crate) fn moved(&self, arm_m: Vec3) -> Self {
        let arm = cross_matrix(arm_m);
        let coupling = self.coupling + arm * self.linear;
        Self {
            angular: self.angular + arm * self.coupling.transpose() - coupling * arm,
            coupling,
            linear: self.linear,
        }
    }
}
