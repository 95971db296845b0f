//! Options of an import.

use glam::DVec3;

/// Choices of the user that the file leaves open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Names of joints to leave out, together with everything that only they connect; for an MJCF, names of bodies
    /// too.
    pub cut: Vec<String>,
    /// Whether to import a mechanism with closed loops as the tree in the file. The loops stay open.
    pub open_loops: bool,
    /// Whether to replace impossible inertia by that of a ball with the same sum of principal moments (the rule of
    /// MuJoCo's `balanceinertia`), and missing inertia, if no solid gives it, by that of a point.
    pub repair_inertia: bool,
    /// Length of the file's unit, m. Default: the length that an MJCF's gravity implies, otherwise 1. Masses,
    /// efforts, friction and damping are always in SI units.
    pub metres_per_unit: Option<f64>,
    /// Axis of the file that points up, unit vector. Default: opposite to an MJCF's gravity, otherwise z.
    pub up: Option<DVec3>,
}
