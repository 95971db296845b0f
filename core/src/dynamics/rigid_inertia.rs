//! The inertia of a rigid body about its origin, in ten numbers.

use glam::{Mat3, Vec3};

use crate::inertia::Inertia;
use crate::symmetric::Symmetric;
use crate::transform::Wrench;

/// Inertia of a body, or of bodies that are rigidly connected, in the axes of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct RigidInertia {
    pub(crate) mass_kg: f32,
    /// Mass times the vector from the origin to the centre of mass.
    pub(crate) first_moment_kg_m: Vec3,
    /// Rotational inertia about the origin.
    pub(crate) rotational_kg_m2: Symmetric,
}

impl RigidInertia {
    /// Returns the inertia of a body about the origin of its frame.
    #[inline]
    pub(crate) fn of(inertia: &Inertia) -> Self {
        Self {
            mass_kg: inertia.mass_kg,
            first_moment_kg_m: Vec3::ZERO,
            rotational_kg_m2: Symmetric::from(&inertia.rotational_kg_m2),
        }
        .moved(inertia.center_of_mass_m)
    }

    /// Returns the inertia about another origin, by the parallel axis theorem. `arm_m` is the vector from the new
    /// origin to this one.
    #[inline]
    pub(crate) fn moved(&self, arm_m: Vec3) -> Self {
        let Self { mass_kg, first_moment_kg_m, rotational_kg_m2 } = *self;
        let way = arm_m * mass_kg;
        // -[p][h] - [h][p] - m [p][p], with k = h + ½ m p, is 2 (p · k) 1 - p kᵀ - k pᵀ.
        let halfway = first_moment_kg_m + way * 0.5;
        let about_arm = Symmetric::diagonal(2.0 * arm_m.dot(halfway));
        Self {
            mass_kg,
            first_moment_kg_m: first_moment_kg_m + way,
            rotational_kg_m2: rotational_kg_m2 + about_arm - Symmetric::from_outer(arm_m, halfway),
        }
    }

    /// Returns the inertia in rotated axes.
    #[inline]
    pub(crate) fn turned(&self, rotation: &Mat3) -> Self {
        Self {
            mass_kg: self.mass_kg,
            first_moment_kg_m: *rotation * self.first_moment_kg_m,
            rotational_kg_m2: self.rotational_kg_m2.turned(rotation),
        }
    }

    pub(crate) fn plus(&self, other: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            first_moment_kg_m: self.first_moment_kg_m + other.first_moment_kg_m,
            rotational_kg_m2: self.rotational_kg_m2 + other.rotational_kg_m2,
        }
    }

    /// Returns the wrench that gives 1 rad/s² about an axis through the origin, from rest.
    #[inline]
    pub(crate) fn of_turn(&self, axis: Vec3) -> Wrench {
        Wrench {
            moment_nm: self.rotational_kg_m2 * axis,
            force_n: axis.cross(self.first_moment_kg_m),
        }
    }

    /// Returns the wrench that gives 1 m/s² along an axis, from rest.
    #[inline]
    pub(crate) fn of_slide(&self, axis: Vec3) -> Wrench {
        Wrench { moment_nm: self.first_moment_kg_m.cross(axis), force_n: axis * self.mass_kg }
    }

    /// Returns [`Self::of_turn`] for x, y and z.
    #[inline]
    pub(crate) fn of_turns(&self) -> [Wrench; 3] {
        let Self { first_moment_kg_m: Vec3 { x, y, z }, rotational_kg_m2, .. } = *self;
        [
            Wrench::new(rotational_kg_m2.x_axis(), Vec3::new(0.0, -z, y)),
            Wrench::new(rotational_kg_m2.y_axis(), Vec3::new(z, 0.0, -x)),
            Wrench::new(rotational_kg_m2.z_axis(), Vec3::new(-y, x, 0.0)),
        ]
    }

    /// Returns [`Self::of_slide`] for x, y and z.
    #[inline]
    pub(crate) fn of_slides(&self) -> [Wrench; 3] {
        [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| self.of_slide(axis))
    }
}
