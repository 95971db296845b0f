//! The mass properties of a body.

use glam::{DMat3, DVec3};

/// Mass and mass distribution of a body, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MassProperties {
    /// Mass in kg.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, in metres.
    pub center_of_mass_m: DVec3,
    /// Rotational inertia about the centre of mass, body axes.
    pub rotational_kg_m2: DMat3,
}

impl MassProperties {
    /// Returns the mass properties of a body of `factor` times the dimensions, at the same density.
    #[must_use]
    pub fn scaled(&self, factor: f64) -> Self {
        let (area, volume) = (factor * factor, factor * factor * factor);
        Self {
            mass_kg: self.mass_kg * volume,
            center_of_mass_m: self.center_of_mass_m * factor,
            rotational_kg_m2: self.rotational_kg_m2 * (volume * area),
        }
    }
}
