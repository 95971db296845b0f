//! The exact plant: reduced coordinates, which keep joints from drifting apart, and our own forward dynamics in
//! f64. It is the reference for the other plants.

#![expect(clippy::inline_always, reason = "see `sinew_batch::Work::run`")]

mod articulated_body;
mod bounds;
mod dynamics;
mod joint;
mod lanes;
mod spatial;
#[cfg(test)]
mod tests;
mod tree;
mod turn;
mod weight;

use std::array::from_fn;

use glam::DVec3;
use sinew_batch::{Work, widest};

use super::check::check;
use super::{Description, Drive, Mechanism, MovingPose, Plant, PlantError, Pose, Settings};
use tree::Tree;

/// A mechanism in reduced coordinates: a position and a velocity for each dof of its joints. Or `L` mechanisms with
/// the same joints, which take their steps together.
///
/// Accepts any tree of joints, with rotor inertia, viscous and Coulomb friction, and ranges. Viscous friction is
/// implicit; Coulomb friction and the ends of ranges hold a joint exactly: see `bounds.rs`. All three are stable
/// for any step size.
///
/// Each substep is a step of semi-implicit Euler, velocities first. Over the substeps the torques are constant in
/// the axes of the bodies on which they act, like those of motors, and the root's force is constant in the root's
/// axes.
///
/// Several mechanisms are computed in the lanes of vector instructions. Each has the operations of a mechanism alone
/// in the same order, so its poses have the same bits, whatever the others do.
#[derive(Debug, Clone)]
pub struct ArticulatedPlant<const L: usize = 1> {
    tree: Tree<L>,
    dt_s: f64,
    substeps: usize,
    poses: [Vec<Pose>; L],
}

/// Number of mechanisms that are computed at once: the widest vector registers hold this number of f64.
pub const LANES: usize = 8;

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
        Ok(Self::of_tree(Tree::new(mechanism, start), dt_s, substeps))
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
        self.tree.set_drives(&[drive]);
        self.tree.accelerate(self.dt_s / self.substeps as f64);
        let links = &self.tree.links;
        Accelerations {
            root_m_s2: self.tree.root_acceleration_m_s2.at(0),
            joints_rad_s2: links.iter().map(|link| link.spin_rate_rad_s2.at(0)).collect(),
            slides_m_s2: links.iter().map(|link| link.slide_rate_m_s2.at(0)).collect(),
        }
    }

    /// Returns the poses and velocities of the bodies.
    pub fn motions(&self) -> Vec<MovingPose> {
        self.tree.motions(&self.poses[0])
    }
}

// Not generic: this crate's optimization applies, not that of the crate that calls these functions.
impl ArticulatedPlant<LANES> {
    /// Joins mechanisms of ball joints without rotor, friction and range, each in its state. Returns `None` if a
    /// mechanism has another joint, or if the mechanisms, their time steps or their gravity differ.
    pub fn join(plants: [&ArticulatedPlant; LANES]) -> Option<Self> {
        let ArticulatedPlant { dt_s, substeps, .. } = *plants[0];
        let alike = |plant: &&ArticulatedPlant| {
            plant.dt_s.to_bits() == dt_s.to_bits() && plant.substeps == substeps
        };
        let tree = Tree::join(plants.map(|plant| &plant.tree))?;
        plants.iter().all(alike).then(|| Self::of_tree(tree, dt_s, substeps))
    }

    /// Advances all mechanisms by one step with constant drives.
    pub fn step_all(&mut self, drives: [&Drive; LANES]) {
        widest(Step { plant: self, drives });
    }

    /// Returns the poses of all bodies of a mechanism, by body.
    pub fn poses_of(&self, lane: usize) -> &[Pose] {
        &self.poses[lane]
    }
}

impl<const L: usize> ArticulatedPlant<L> {
    fn of_tree(tree: Tree<L>, dt_s: f64, substeps: usize) -> Self {
        let mut poses = from_fn(|_| Vec::with_capacity(tree.links.len()));
        tree.poses(&mut poses);
        Self { tree, dt_s, substeps, poses }
    }
}

struct Step<'a, const L: usize> {
    plant: &'a mut ArticulatedPlant<L>,
    drives: [&'a Drive; L],
}

impl<const L: usize> Work for Step<'_, L> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Self { plant: ArticulatedPlant { tree, dt_s, substeps, poses }, drives } = self;
        tree.set_drives(&drives);
        let h = *dt_s / *substeps as f64;
        for _ in 0..*substeps {
            tree.accelerate(h);
            tree.advance(h);
        }
        tree.poses(poses);
    }
}

impl Plant for ArticulatedPlant {
    fn step(&mut self, drive: &Drive) {
        Step { plant: self, drives: [drive] }.run();
    }

    fn poses(&self) -> &[Pose] {
        &self.poses[0]
    }

    fn as_articulated(&self) -> Option<&ArticulatedPlant> {
        Some(self)
    }
}
