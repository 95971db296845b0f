//! What bodies weigh: mass properties in f64, and those of solids.

use std::f64::consts::PI;

use glam::{DMat3, DQuat, DVec3};
use sinew_core::{Inertia, InertiaError, RotationalInertia};

use crate::description::InertiaMatrix;

/// Mass, centre of mass, and inertia about it, in the axes of one frame.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct MassProperties {
    pub(super) mass_kg: f64,
    pub(super) center_m: DVec3,
    pub(super) inertia_kg_m2: DMat3,
}

impl MassProperties {
    /// The same body, seen from a frame in which its own lies at `position_m`, turned by `rotation`.
    pub(super) fn placed(&self, position_m: DVec3, rotation: DQuat) -> Self {
        let r = DMat3::from_quat(rotation);
        Self {
            mass_kg: self.mass_kg,
            center_m: position_m + rotation * self.center_m,
            inertia_kg_m2: r * self.inertia_kg_m2 * r.transpose(),
        }
    }

    /// Several bodies as one.
    pub(super) fn sum(parts: &[Self]) -> Self {
        let mass_kg: f64 = parts.iter().map(|part| part.mass_kg).sum();
        if mass_kg <= 0.0 {
            return Self::default();
        }
        let moment: DVec3 = parts.iter().map(|part| part.center_m * part.mass_kg).sum();
        let center_m = moment / mass_kg;
        let inertia_kg_m2 = parts
            .iter()
            .map(|part| part.inertia_kg_m2 + part.mass_kg * of_point(part.center_m - center_m))
            .fold(DMat3::ZERO, |sum, part| sum + part);
        Self { mass_kg, center_m, inertia_kg_m2 }
    }

    /// Refuses what no body can have, by the rule of `sinew-core`.
    pub(super) fn check(&self) -> Result<(), InertiaError> {
        let [x, y, z] = self.inertia_kg_m2.as_mat3().to_cols_array_2d();
        let rotational_kg_m2 =
            RotationalInertia { xx: x[0], xy: y[0], xz: z[0], yy: y[1], yz: z[1], zz: z[2] };
        Inertia {
            mass_kg: self.mass_kg as f32,
            center_of_mass_m: self.center_m.as_vec3(),
            rotational_kg_m2,
        }
        .validate()
    }

    /// A ball with the same sum of principal moments: the rule of MuJoCo's `balanceinertia`.
    pub(super) fn balanced(&self) -> Self {
        let m = self.inertia_kg_m2;
        let mean = ((m.x_axis.x + m.y_axis.y + m.z_axis.z) / 3.0).max(0.0);
        let mean = if self.mass_kg > 0.0 { mean } else { 0.0 };
        Self { inertia_kg_m2: DMat3::from_diagonal(DVec3::splat(mean)), ..*self }
    }

    /// As a rig has it; `None` of a point and of a frame without mass.
    pub(super) fn matrix(&self) -> Option<InertiaMatrix> {
        let [x, y, z] = self.inertia_kg_m2.to_cols_array_2d();
        let is_point = self.inertia_kg_m2.abs_diff_eq(DMat3::ZERO, 0.0);
        // Zero is added so that no -0 is written.
        (!is_point).then(|| InertiaMatrix {
            xx: x[0] + 0.0,
            xy: y[0] + 0.0,
            xz: z[0] + 0.0,
            yy: y[1] + 0.0,
            yz: z[1] + 0.0,
            zz: z[2] + 0.0,
        })
    }
}

/// Inertia of a point of 1 kg at `arm`, about the origin, m².
fn of_point(arm: DVec3) -> DMat3 {
    let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
    DMat3::from_diagonal(DVec3::splat(arm.length_squared())) - outer
}

/// A solid about its centre; cylinders and capsules along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Solid {
    /// Edges, m.
    Box(DVec3),
    /// Semi-axes, m.
    Ellipsoid(DVec3),
    /// Radius and length, m.
    Cylinder(f64, f64),
    /// Radius, and length without the two half balls, m.
    Capsule(f64, f64),
}

impl Solid {
    pub(super) fn volume_m3(&self) -> f64 {
        match *self {
            Self::Box(edges) => edges.element_product(),
            Self::Ellipsoid(axes) => 4.0 / 3.0 * PI * axes.element_product(),
            Self::Cylinder(r, length) => PI * r * r * length,
            Self::Capsule(r, length) => PI * r * r * (length + 4.0 / 3.0 * r),
        }
    }

    /// Of even density.
    pub(super) fn mass_properties(&self, mass_kg: f64) -> MassProperties {
        let moments = match *self {
            Self::Box(edges) => across(edges * edges) / 12.0,
            Self::Ellipsoid(axes) => across(axes * axes) / 5.0,
            Self::Cylinder(r, length) => of_cylinder(r, length),
            Self::Capsule(r, length) => {
                // A cylinder, and two half balls, each with its own centre 3/8 r beyond the end.
                let ends = 4.0 * r / (4.0 * r + 3.0 * length);
                let ball = 0.4 * r * r;
                let sideways = ball + length * (3.0 * r + 2.0 * length) / 8.0;
                of_cylinder(r, length) * (1.0 - ends)
                    + DVec3::new(sideways, sideways, ball) * ends
            }
        };
        let inertia_kg_m2 = DMat3::from_diagonal(moments * mass_kg);
        MassProperties { mass_kg, center_m: DVec3::ZERO, inertia_kg_m2 }
    }
}

/// About each axis, what lies along the two others.
fn across(squares: DVec3) -> DVec3 {
    DVec3::new(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y)
}

fn of_cylinder(r: f64, length: f64) -> DVec3 {
    let sideways = (3.0 * r * r + length * length) / 12.0;
    DVec3::new(sideways, sideways, 0.5 * r * r)
}
