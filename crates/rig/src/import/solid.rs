//! Inertia of solids of uniform density.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::description::BodyShape;
use crate::description::mass::Mass;

/// A solid about its centre; cylinders and capsules are along z.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Solid {
    /// Edge lengths, m.
    Box(DVec3),
    /// Semi-axes, m.
    Ellipsoid(DVec3),
    /// Radius and length, m.
    Cylinder(f64, f64),
    /// Radius, and length without the two hemispheres, m.
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

    /// Returns the solid as it is drawn; `None` for an ellipsoid that is not a sphere, and for a solid without extent.
    pub(super) fn shape(&self) -> Option<BodyShape> {
        let extends = |lengths: &[f64]| lengths.iter().all(|length| *length > 0.0);
        match *self {
            Self::Box(edges) => {
                extends(&edges.to_array()).then(|| BodyShape::cuboid(edges.to_array()))
            }
            Self::Ellipsoid(axes) => {
                let is_sphere = axes.abs_diff_eq(DVec3::splat(axes.x), 0.0) && axes.x > 0.0;
                is_sphere.then(|| BodyShape::sphere(axes.x))
            }
            Self::Cylinder(r, length) => {
                extends(&[r, length]).then(|| BodyShape::cylinder(r, length))
            }
            Self::Capsule(r, length) => {
                extends(&[r, length]).then(|| BodyShape::capsule(r, length))
            }
        }
    }

    /// Returns mass and inertia of the solid at uniform density.
    pub(super) fn filled(&self, mass_kg: f64) -> Mass {
        let moments = match *self {
            Self::Box(edges) => across(edges * edges) / 12.0,
            Self::Ellipsoid(axes) => across(axes * axes) / 5.0,
            Self::Cylinder(r, length) => of_cylinder(r, length),
            Self::Capsule(r, length) => {
                // A cylinder and two hemispheres. The centre of mass of a hemisphere is 3/8 r beyond the cylinder's
                // end.
                let ends = 4.0 * r / (4.0 * r + 3.0 * length);
                let ball = 0.4 * r * r;
                let sideways = ball + length * (3.0 * r + 2.0 * length) / 8.0;
                of_cylinder(r, length) * (1.0 - ends) + DVec3::new(sideways, sideways, ball) * ends
            }
        };
        let inertia_kg_m2 = DMat3::from_diagonal(moments * mass_kg);
        Mass { kg: mass_kg, center_m: DVec3::ZERO, inertia_kg_m2 }
    }
}

/// Returns, for each axis, the sum of the squares along the other two axes.
fn across(squares: DVec3) -> DVec3 {
    DVec3::new(squares.y + squares.z, squares.z + squares.x, squares.x + squares.y)
}

fn of_cylinder(r: f64, length: f64) -> DVec3 {
    let sideways = (3.0 * r * r + length * length) / 12.0;
    DVec3::new(sideways, sideways, 0.5 * r * r)
}
