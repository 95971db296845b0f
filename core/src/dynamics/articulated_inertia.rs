//! The articulated inertia of a body with all bodies that its joints carry, in 21 numbers.

use glam::{Mat3, Vec3};

use super::rigid_inertia::RigidInertia;
use crate::matrix::{cross_matrix, outer};
use crate::symmetric::Symmetric;
use crate::transform::{Twist, Wrench};

/// Wrench per acceleration of a body, both at its origin and in one frame's axes: a symmetric 6 x 6 matrix.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ArticulatedInertia {
    /// Moment per angular acceleration.
    pub(crate) angular: Symmetric,
    /// Moment per linear acceleration; its transpose is force per angular acceleration.
    pub(crate) coupling: Mat3,
    /// Force per linear acceleration.
    pub(crate) linear: Symmetric,
}

impl ArticulatedInertia {
    pub(crate) const ZERO: Self =
        Self { angular: Symmetric::ZERO, coupling: Mat3::ZERO, linear: Symmetric::ZERO };

    /// Returns an inertia that resists rotation, and translation, equally in every direction: `angular` and
    /// `linear` times the identity.
    pub(crate) fn round(angular: f32, linear: f32) -> Self {
        Self {
            angular: Symmetric::diagonal(angular),
            coupling: Mat3::ZERO,
            linear: Symmetric::diagonal(linear),
        }
    }

    #[inline]
    pub(crate) fn wrench(&self, acceleration: Twist) -> Wrench {
        let (turn, slide) =
            (self.of_turn(acceleration.angular), self.of_slide(acceleration.linear));
        turn + slide
    }

    /// Returns the wrench per angular acceleration along an axis.
    #[inline]
    pub(crate) fn of_turn(&self, axis: Vec3) -> Wrench {
        Wrench { moment_nm: self.angular * axis, force_n: transposed_mul(&self.coupling, axis) }
    }

    /// Returns the wrench per linear acceleration along an axis.
    #[inline]
    pub(crate) fn of_slide(&self, axis: Vec3) -> Wrench {
        Wrench { moment_nm: self.coupling * axis, force_n: self.linear * axis }
    }

    /// Removes a dof that yields to forces. `wrench` is the wrench per acceleration along the dof. `per_force` is
    /// the acceleration along the dof per force along the dof.
    #[inline]
    pub(crate) fn give_way(&mut self, wrench: &Wrench, per_force: f32) {
        let Wrench { moment_nm, force_n } = *wrench;
        self.angular += Symmetric::from_outer(moment_nm, moment_nm * (-0.5 * per_force));
        self.coupling -= outer(moment_nm * per_force, force_n);
        self.linear += Symmetric::from_outer(force_n, force_n * (-0.5 * per_force));
    }

    /// Adds the inertia of a child at a distance `arm_m` from this body's origin. `rotation` turns the child's axes
    /// to this body's axes.
    #[inline]
    pub(crate) fn add(&mut self, child: &Self, rotation: &Mat3, arm_m: Vec3) {
        self.add_at(
            &Self {
                angular: child.angular.turned(rotation),
                coupling: *rotation * child.coupling * rotation.transpose(),
                linear: child.linear.turned(rotation),
            },
            arm_m,
        );
    }

    /// Adds a child like [`Self::add`], in the axes of this body.
    #[inline]
    pub(crate) fn add_at(&mut self, child: &Self, arm_m: Vec3) {
        let Self { angular, coupling, linear } = *child;
        let by_arm = arm_times(arm_m, &linear);
        // [p] Bᵀ - B [p] - [p] M [p] equals Z + Zᵀ with Z = [p] (B + ½ [p] M)ᵀ.
        let halfway = (coupling + by_arm * 0.5).transpose();
        let z = Mat3::from_cols(
            arm_m.cross(halfway.x_axis),
            arm_m.cross(halfway.y_axis),
            arm_m.cross(halfway.z_axis),
        );
        self.angular += angular + twice_symmetric_part(&z);
        self.coupling += coupling + by_arm;
        self.linear += linear;
    }

    /// Adds a child like [`Self::add`], if the child resists only the acceleration of its origin.
    #[inline]
    pub(crate) fn add_linear(&mut self, child: &Symmetric, rotation: &Mat3, arm_m: Vec3) {
        self.add_linear_at(&child.turned(rotation), arm_m);
    }

    /// Adds a child like [`Self::add_linear`], in the axes of this body.
    #[inline]
    pub(crate) fn add_linear_at(&mut self, child: &Symmetric, arm_m: Vec3) {
        let by_arm = arm_times(arm_m, child);
        // -[p] M [p]
        self.angular += Symmetric::from_product(&cross_matrix(arm_m), &by_arm.transpose());
        self.coupling += by_arm;
        self.linear += *child;
    }
}

impl From<&RigidInertia> for ArticulatedInertia {
    #[inline]
    fn from(rigid: &RigidInertia) -> Self {
        Self {
            angular: rigid.rotational_kg_m2,
            coupling: cross_matrix(rigid.first_moment_kg_m),
            linear: Symmetric::diagonal(rigid.mass_kg),
        }
    }
}

/// Returns `Mᵀ v`.
#[inline]
pub(crate) fn transposed_mul(m: &Mat3, v: Vec3) -> Vec3 {
    Vec3::new(m.x_axis.dot(v), m.y_axis.dot(v), m.z_axis.dot(v))
}

/// Returns `[p] M`.
#[inline]
fn arm_times(arm_m: Vec3, m: &Symmetric) -> Mat3 {
    Mat3::from_cols(arm_m.cross(m.x_axis()), arm_m.cross(m.y_axis()), arm_m.cross(m.z_axis()))
}

/// Returns `Z + Zᵀ`.
#[inline]
fn twice_symmetric_part(z: &Mat3) -> Symmetric {
    Symmetric {
        xx: 2.0 * z.x_axis.x,
        xy: z.x_axis.y + z.y_axis.x,
        xz: z.x_axis.z + z.z_axis.x,
        yy: 2.0 * z.y_axis.y,
        yz: z.y_axis.z + z.z_axis.y,
        zz: 2.0 * z.z_axis.z,
    }
}
