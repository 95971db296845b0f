//! Bodies.

/// A rigid body. Its frame is the frame of the joint that moves it, after the joint's own motion.
///
/// Without mass it is kinematic: it follows, and takes no torque. Give an inertia, or the size of a box of the same
/// mass, or neither for a point at the centre of mass.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Body {
    /// What people call it; unique among bodies.
    pub name: String,
    /// Mass in kg; zero for a frame that carries nothing.
    pub mass_kg: f64,
    /// Centre of mass in the body frame, m.
    pub center_of_mass_m: [f64; 3],
    /// Inertia about the centre of mass, body axes.
    pub inertia_kg_m2: Option<InertiaMatrix>,
    /// Edges, along the body axes, of a solid box about the centre of mass that has this body's inertia, m.
    pub box_m: Option<[f64; 3]>,
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
    /// All elements times a factor: the same body in another unit.
    #[must_use]
    pub fn scaled(self, factor: f64) -> Self {
        let Self { xx, xy, xz, yy, yz, zz } = self;
        let [xx, xy, xz, yy, yz, zz] = [xx, xy, xz, yy, yz, zz].map(|element| element * factor);
        Self { xx, xy, xz, yy, yz, zz }
    }
}
