//! The exact plant: reduced coordinates, so that joints cannot drift apart, and forward dynamics of our own
//! in f64. It is the judge of the others.

mod articulated_body;
mod bounds;
mod dynamics;
mod joint;
mod spatial;
#[cfg(test)]
mod tests;
mod tree;
mod weight;

use glam::DVec3;

use super::check::check;
use super::{Description, Drive, Mechanism, MovingPose, Plant, PlantError, Pose, Settings};
use tree::Tree;

/// A mechanism in reduced coordinates: a position and a velocity for each dof of its joints.
///
/// Takes any tree of joints, with what their rotors add to their inertia, viscous and Coulomb friction, and ranges.
/// Viscous friction is implicit, Coulomb friction and the ends of ranges hold a joint exactly: see `bounds.rs`. All
/// three are stable at any step.
///
/// Each substep is one of semi-implicit Euler, the velocities first. The torques are held over the substeps
/// in the axes of the bodies that they act on, as motors do, the root's force in the root's.
#[derive(Debug, Clone)]
pub struct ArticulatedPlant {
    tree: Tree,
    dt_s: f64,
    substeps: usize,
    poses: Vec<Pose>,
}

/// How a mechanism accelerates.
#[derive(Debug, Clone, PartialEq)]
pub struct Accelerations {
    /// Classical acceleration of the root's origin in m/s², world axes.
    pub root_m_s2: DVec3,
    /// By joint, in rad/s², along the turns that it leaves free: the derivative of the components in body axes of its
    /// body's angular velocity against the parent, the root's against the world.
    pub joints_rad_s2: Vec<DVec3>,
    /// By joint, in m/s², along the slides that it leaves free, body axes; the root's are above.
    pub slides_m_s2: Vec<DVec3>,
}

impl ArticulatedPlant {
    /// Builds the mechanism in the given state, one of `start` per body.
    ///
    /// The joints take their positions and velocities along what they leave free from it. A bolted root has no
    /// velocity.
    ///
    /// # Errors
    /// [`PlantError`] if this is no tree with a state for each body, or a number is one that no machine has.
    pub fn new(
        mechanism: &Mechanism,
        start: &[MovingPose],
        dt_s: f64,
        substeps: usize,
    ) -> Result<Self, PlantError> {
        check(mechanism, start, dt_s, substeps)?;
        weight::check(mechanism, start)?;
        let tree = Tree::new(mechanism, start);
        let mut poses = Vec::with_capacity(start.len());
        tree.poses(&mut poses);
        Ok(Self { tree, dt_s, substeps, poses })
    }

    /// The same under another gravity, in m/s², world axes.
    #[must_use]
    pub fn with_gravity(mut self, gravity_m_s2: DVec3) -> Self {
        self.tree.gravity_m_s2 = gravity_m_s2;
        self
    }

    /// What this plant is.
    pub const fn description(substeps: usize) -> Description {
        Description {
            name: "articulated",
            engine: "articulated-body algorithm in f64",
            settings: Settings {
                integrator: "semi-implicit Euler, rotations by the exponential map",
                substeps,
                solver_sweeps: None,
                gyroscopic_term: "exact",
                contacts: false,
            },
        }
    }

    /// Forward dynamics: the accelerations that the drives make in the present state.
    pub fn accelerations(&mut self, drive: &Drive) -> Accelerations {
        self.tree.set_drive(drive);
        self.tree.accelerate(self.dt_s / self.substeps as f64);
        Accelerations {
            root_m_s2: self.tree.root_acceleration_m_s2,
            joints_rad_s2: self.tree.links.iter().map(|link| link.spin_rate_rad_s2).collect(),
            slides_m_s2: self.tree.links.iter().map(|link| link.slide_rate_m_s2).collect(),
        }
    }

    /// How the bodies move.
    pub fn motions(&self) -> Vec<MovingPose> {
        self.tree.motions(&self.poses)
    }
}

impl Plant for ArticulatedPlant {
    fn step(&mut self, drive: &Drive) {
        self.tree.set_drive(drive);
        let h = self.dt_s / self.substeps as f64;
        for _ in 0..self.substeps {
            self.tree.accelerate(h);
            self.tree.advance(h);
        }
        self.tree.poses(&mut self.poses);
    }

    fn poses(&self) -> &[Pose] {
        &self.poses
    }
}
