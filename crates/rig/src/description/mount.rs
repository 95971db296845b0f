//! Where the base stands, and what feeds the servos.

/// How the base stands in the world: y up, gravity 9.81 m/s² along -y.
///
/// A file that has z up is turned here, once: `rotation_xyzw = [-0.7071.., 0, 0, 0.7071..]`. A rig that sticks out of a
/// wall, or hangs upside down, says so here as well.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Whether the base is bolted to the world, or moves freely and is driven there.
    pub base: Base,
    /// Position of the base in the world, m.
    pub position_m: [f64; 3],
    /// Rotation of the base in the world, unit quaternion x y z w.
    pub rotation_xyzw: [f64; 4],
}

/// How the base is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Base {
    /// Bolted to the world, or to a stand.
    #[default]
    Fixed,
    /// On a drive of six dofs.
    Driven,
}

impl Default for Mount {
    fn default() -> Self {
        Self { base: Base::Fixed, position_m: [0.0; 3], rotation_xyzw: [0.0, 0.0, 0.0, 1.0] }
    }
}

impl Mount {
    /// A base whose own z axis points up.
    pub fn z_up() -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Self { rotation_xyzw: [-half, 0.0, 0.0, half], ..Self::default() }
    }
}

/// What feeds the servos.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Supply {
    /// V.
    pub voltage_v: f64,
    /// The most that it gives for long, A.
    pub current_a: f64,
}
