//! Position of the base, and the power supply of the servos.

/// Pose of the base in the world. In the world, y points up and gravity is 9.81 m/s² along -y.
///
/// A file with z up is rotated here, once: `rotation_xyzw = [-0.7071.., 0, 0, 0.7071..]`. A rig on a wall, or one
/// that is mounted upside down, is rotated here too.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Whether the base is bolted to the world, or moved by a drive.
    pub base: Base,
    /// Position of the base in the world, m.
    pub position_m: [f64; 3],
    /// Rotation of the base in the world, unit quaternion x y z w.
    pub rotation_xyzw: [f64; 4],
}

/// Support of the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Base {
    /// Bolted to the world, or to a stand.
    #[default]
    Fixed,
    /// Moved by a drive of six dofs.
    Driven,
}

impl Default for Mount {
    fn default() -> Self {
        Self { base: Base::Fixed, position_m: [0.0; 3], rotation_xyzw: [0.0, 0.0, 0.0, 1.0] }
    }
}

impl Mount {
    /// Returns a mount for a base whose own z axis points up.
    pub fn z_up() -> Self {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        Self { rotation_xyzw: [-half, 0.0, 0.0, half], ..Self::default() }
    }
}

/// Power supply of the servos.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Supply {
    /// Voltage, V.
    pub voltage_v: f64,
    /// Maximum continuous current, A.
    pub current_a: f64,
}
