//! Rigid bodies and their inertia.

use super::BodyShape;

/// A rigid body. Its frame is the frame of the joint that moves it, after the joint's own motion.
///
/// A body without mass is kinematic: it follows its joint, and needs no torque. The inertia is given by a matrix or
/// by the size of a box of the same mass; without both, the mass is a point at the centre of mass.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Body {
    /// Name of the body; unique among bodies.
    pub name: String,
    /// Mass, kg; zero for a frame without mass.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, m.
    pub center_of_mass_m: [f64; 3],
    /// Inertia about the centre of mass, in body axes, kg m².
    pub inertia_kg_m2: Option<InertiaMatrix>,
    /// Edge lengths of a solid box about the centre of mass that has this body's inertia, along the body axes, m.
    pub box_m: Option<[f64; 3]>,
    /// Solids that are drawn for this body; without any, the box of `box_m`.
    pub shapes: Vec<BodyShape>,
}

/// Elements of a symmetric matrix; `xy`, `xz`, `yz` are the negated products of inertia.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[expect(missing_docs, reason = "the fields are the elements that the type's line names")]
pub struct InertiaMatrix {
    pub xx: f64,
    pub xy: f64,
    pub xz: f64,
    pub yy: f64,
    pub yz: f64,
    pub zz: f64,
}

impl InertiaMatrix {
    /// Returns all elements times a factor, for example to change the unit.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let Self { xx, xy, xz, yy, yz, zz } = self;
        let [xx, xy, xz, yy, yz, zz] = [xx, xy, xz, yy, yz, zz].map(|element| element * factor);
        Self { xx, xy, xz, yy, yz, zz }
    }
}
