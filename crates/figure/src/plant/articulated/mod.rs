//! The exact plant: reduced coordinates, which keep joints from drifting apart, and our own forward dynamics in
//! f64. It is the reference for the other plants.

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
/// Accepts any tree of joints, with rotor inertia, viscous and Coulomb friction, and ranges. Viscous friction is
/// implicit; Coulomb friction and the ends of ranges hold a joint exactly: see `bounds.rs`. All three are stable
/// for any step size.
///
/// Each substep is a step of semi-implicit Euler, velocities first. Over the substeps the torques are constant in
/// the axes of the bodies on which they act, like those of motors, and the root's force is constant in the root's
/// axes.
#[derive(Debug, Clone)]
pub struct ArticulatedPlant {
    tree: Tree,
    dt_s: f64,
    substeps: usize,
    poses: Vec<Pose>,
}

/// Accelerations of a mechanism.
#[derive(Debug, Clone, PartialEq)]
pub struct Accelerations {
    /// Classical acceleration of the root's origin in m/s², world axes.
    pub root_m_s2: DVec3,
    /// Angular acceleration of each joint in rad/s², along its rotational dofs: the derivative of the components
    /// in body axes of its body's angular velocity relative to the parent. The root's is relative to the world.
    pub joints_rad_s2: Vec<DVec3>,
    /// Linear acceleration of each joint in m/s², along its translational dofs, body axes. For the root see
    /// `root_m_s2`.
    pub slides_m_s2: Vec<DVec3>,
}

impl ArticulatedPlant {
    /// Builds the mechanism in the given state. `start` has one state per body.
    ///
    /// The position and velocity of each joint along its dofs are computed from `start`. A bolted root has no velocity.
    ///
    /// # Errors
    /// [`PlantError`] if this is not a tree with a state for each body, a number is physically impossible, the step or
    /// the substeps are not positive, or a joint can move without moving any inertia.
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

    /// Sets gravity, in world axes, m/s².
    #[must_use]
    pub fn with_gravity(mut self, gravity_m_s2: DVec3) -> Self {
        self.tree.gravity_m_s2 = gravity_m_s2;
        self
    }

    /// Returns a description of this plant.
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

    /// Computes forward dynamics: the accelerations under the drives in the present state.
    pub fn accelerations(&mut self, drive: &Drive) -> Accelerations {
        self.tree.set_drive(drive);
        self.tree.accelerate(self.dt_s / self.substeps as f64);
        Accelerations {
            root_m_s2: self.tree.root_acceleration_m_s2,
            joints_rad_s2: self.tree.links.iter().map(|link| link.spin_rate_rad_s2).collect(),
            slides_m_s2: self.tree.links.iter().map(|link| link.slide_rate_m_s2).collect(),
        }
    }

    /// Returns the poses and velocities of the bodies.
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
