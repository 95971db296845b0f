//! Masses of a file's bodies: checks, and conversion to a rig's body.

use glam::{DMat3, DVec3};

use crate::description::mass::Mass;
use crate::description::{Body, InertiaMatrix, is_possible};

/// Smallest mass that counts, kg. Exporters give frames a tiny mass, because some programs fail on zero.
pub(super) const MASS_MIN_KG: f64 = 1e-6;

impl Mass {
    /// Creates a point mass at the origin.
    pub(super) fn point(kg: f64) -> Self {
        Self { kg, center_m: DVec3::ZERO, inertia_kg_m2: DMat3::ZERO }
    }

    /// Returns why no real body can have this inertia; `None` if it is possible.
    pub(super) fn fault(&self) -> Option<&'static str> {
        let inertia = self.matrix()?;
        if self.kg <= 0.0 {
            Some("inertia without mass")
        } else if inertia.xx.min(inertia.yy).min(inertia.zz) < 0.0 {
            Some("a negative moment of inertia")
        } else if is_possible(&inertia) {
            None
        } else {
            Some("a principal moment that is negative, or larger than the sum of the two others")
        }
    }

    /// Returns this mass with the inertia of a ball that has the same sum of principal moments: the rule of MuJoCo's
    /// `balanceinertia`.
    pub(super) fn balanced(&self) -> Self {
        let m = self.inertia_kg_m2;
        let mean = ((m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0).max(0.0);
        let mean = if self.kg > 0.0 { mean } else { 0.0 };
        Self { inertia_kg_m2: DMat3::from_diagonal(DVec3::splat(mean)), ..*self }
    }

    /// Returns the inertia; `None` for a point, or a frame without mass.
    pub(super) fn matrix(&self) -> Option<InertiaMatrix> {
        let is_point = self.inertia_kg_m2.abs_diff_eq(DMat3::ZERO, 0.0);
        // Adding zero converts -0 to 0.
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] =
            self.inertia_kg_m2.to_cols_array_2d().map(|column| column.map(|number| number + 0.0));
        (!is_point).then_some(InertiaMatrix { xx, xy, xz, yy, yz, zz })
    }

    /// Creates a rig's body with this mass.
    pub(super) fn body(&self, name: &str) -> Body {
        Body {
            name: name.to_owned(),
            mass_kg: self.kg,
            center_of_mass_m: self.center_m.to_array(),
            inertia_kg_m2: self.matrix(),
            ..Body::default()
        }
    }
}
