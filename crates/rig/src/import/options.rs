//! Options of a user for a robot's file.

use glam::DVec3;

/// The user's word on what a file leaves open.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Options {
    /// Joints to leave out, by name, and with them all that then hangs on nothing; of an MJCF, bodies too.
    pub cut: Vec<String>,
    /// Takes a mechanism with closed loops as the tree that the file holds: the loops stay open.
    pub open_loops: bool,
    /// Replaces inertia that no body can have by that of a ball with the same sum of principal moments (what MuJoCo's
    /// `balanceinertia` does), and inertia that neither the file nor a solid gives by that of a point.
    pub repair_inertia: bool,
    /// Length of the file's unit, m. Default: what an MJCF's gravity says, else 1. Masses, efforts, friction and
    /// damping are in SI units whatever it is.
    pub metres_per_unit: Option<f64>,
    /// The axis of the file that points up, unit. Default: against an MJCF's gravity, else z.
    pub up: Option<DVec3>,
}
