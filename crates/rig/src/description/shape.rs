//! Solids that are drawn for a body.

/// Kind of a solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShapeKind {
    /// A box with `size_m`.
    #[default]
    Box,
    /// A sphere with `radius_m`.
    Sphere,
    /// A cylinder along z with `radius_m` and `length_m`.
    Cylinder,
    /// A cylinder along z with `radius_m` and `length_m`, and a half sphere at each end.
    Capsule,
}

/// A solid that is drawn for a body, about its own centre. Motion, loads and boards do not depend on it.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyShape {
    /// Kind of the solid.
    pub kind: ShapeKind,
    /// Edges of a box, m.
    pub size_m: Option<[f64; 3]>,
    /// Radius, m.
    pub radius_m: Option<f64>,
    /// Length of a cylinder, or of a capsule without its half spheres, m.
    pub length_m: Option<f64>,
    /// Centre in the body frame, m.
    pub position_m: [f64; 3],
    /// Rotation in the body frame, unit quaternion x y z w.
    pub rotation_xyzw: [f64; 4],
    /// Red, green and blue from 0 to 1; `None` for the colour of a page.
    pub color_rgb: Option<[f64; 3]>,
}

impl Default for BodyShape {
    fn default() -> Self {
        Self {
            kind: ShapeKind::Box,
            size_m: None,
            radius_m: None,
            length_m: None,
            position_m: [0.0; 3],
            rotation_xyzw: [0.0, 0.0, 0.0, 1.0],
            color_rgb: None,
        }
    }
}

impl BodyShape {
    /// Creates a box about the origin.
    pub fn cuboid(size_m: [f64; 3]) -> Self {
        Self { size_m: Some(size_m), ..Self::default() }
    }

    /// Creates a sphere about the origin.
    pub fn sphere(radius_m: f64) -> Self {
        Self { kind: ShapeKind::Sphere, radius_m: Some(radius_m), ..Self::default() }
    }

    /// Creates a cylinder about the origin, along z.
    pub fn cylinder(radius_m: f64, length_m: f64) -> Self {
        let (radius_m, length_m) = (Some(radius_m), Some(length_m));
        Self { kind: ShapeKind::Cylinder, radius_m, length_m, ..Self::default() }
    }

    /// Creates a capsule about the origin, along z.
    pub fn capsule(radius_m: f64, length_m: f64) -> Self {
        Self { kind: ShapeKind::Capsule, ..Self::cylinder(radius_m, length_m) }
    }

    /// Returns the solid elsewhere in the body frame.
    #[must_use]
    pub fn at(self, position_m: [f64; 3], rotation_xyzw: [f64; 4]) -> Self {
        Self { position_m, rotation_xyzw, ..self }
    }

    /// Returns the solid in a colour.
    #[must_use]
    pub fn colored(self, color_rgb: [f64; 3]) -> Self {
        Self { color_rgb: Some(color_rgb), ..self }
    }
}
