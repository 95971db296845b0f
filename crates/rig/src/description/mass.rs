//! Masses that are combined to one rigid body.

use glam::{DMat3, DQuat, DVec3};

use super::{Body, InertiaMatrix};

/// Mass, its centre, and its inertia about that centre, in the axes of some frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mass {
    pub(crate) kg: f64,
    pub(crate) center_m: DVec3,
    pub(crate) inertia_kg_m2: DMat3,
}

impl Mass {
    /// Returns the mass of a body, in the frame of that body.
    pub(crate) fn of(body: &Body) -> Self {
        let inertia_kg_m2 = match (&body.inertia_kg_m2, body.box_m) {
            (Some(inertia), _) => matrix(inertia),
            (None, Some(size_m)) => {
                // A solid box has m (y² + z²) / 12 about x; y and z follow by rotation of the letters.
                let [x, y, z] = size_m.map(|edge| edge * edge * body.mass_kg / 12.0);
                DMat3::from_diagonal(DVec3::new(y + z, z + x, x + y))
            }
            (None, None) => DMat3::ZERO,
        };
        Self { kg: body.mass_kg, center_m: body.center_of_mass_m.into(), inertia_kg_m2 }
    }

    /// Transforms the mass to a frame in which its own frame has this rotation and position.
    pub(crate) fn seen_from(self, rotation: DQuat, position_m: DVec3) -> Self {
        let r = DMat3::from_quat(rotation);
        Self {
            center_m: position_m + rotation * self.center_m,
            inertia_kg_m2: r * self.inertia_kg_m2 * r.transpose(),
            ..self
        }
    }

    /// Adds two masses by the parallel axis theorem.
    pub(crate) fn plus(self, other: Self) -> Self {
        let kg = self.kg + other.kg;
        if other.kg <= 0.0 {
            return self;
        }
        if self.kg <= 0.0 {
            return other;
        }
        let center_m = (self.kg * self.center_m + other.kg * other.center_m) / kg;
        let about_center = |mass: Self| {
            let d = mass.center_m - center_m;
            let outer = DMat3::from_cols(d * d.x, d * d.y, d * d.z);
            mass.inertia_kg_m2 + mass.kg * (DMat3::from_diagonal(DVec3::splat(d.dot(d))) - outer)
        };
        Self { kg, center_m, inertia_kg_m2: about_center(self) + about_center(other) }
    }
}

fn matrix(inertia: &InertiaMatrix) -> DMat3 {
    let InertiaMatrix { xx, xy, xz, yy, yz, zz } = *inertia;
    DMat3::from_cols_array_2d(&[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}
