//! What is controlled: a simulated mechanism behind one trait.

mod articulated;
mod check;
#[cfg(test)]
mod fixture;
mod mass_properties;
mod rapier;
#[cfg(test)]
mod tests;

use std::fmt;

use glam::DVec3;
use serde::{Deserialize, Serialize};

pub use articulated::{Accelerations, ArticulatedPlant};
pub use check::PlantError;
pub use check::check_link;
pub use mass_properties::MassProperties;
pub use rapier::{EngineSettings, RapierPlant};
pub use sinew_rig::mechanism::GRAVITY_M_S2;
pub use sinew_rig::mechanism::{JointModel, Link, Mechanism, Pose};

/// Which plant, and how its steps are cut.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlantSettings {
    /// The plant.
    pub kind: PlantKind,
    /// Equal parts that a step is cut in, with the torques held; at least 1. An engine may cut them further.
    pub substeps: usize,
}

impl Default for PlantSettings {
    fn default() -> Self {
        Self { kind: PlantKind::Rapier, substeps: 1 }
    }
}

/// The plants there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum PlantKind {
    /// The game engine rapier in maximal coordinates, set up for torque control.
    Rapier,
    /// The same, but with the engine's own gyroscopic term.
    RapierGyroscopic,
    /// rapier as it comes: it cuts each of our substeps in 4 of its own.
    RapierDefaults,
    /// Exact dynamics in reduced coordinates: joints that cannot drift.
    Articulated,
}

impl PlantSettings {
    /// Builds the mechanism in the given state, one of `start` per body; the poses must fit the joints.
    ///
    /// # Errors
    /// [`PlantError`].
    pub fn build(
        &self,
        mechanism: &Mechanism,
        start: &[MovingPose],
        dt_s: f64,
    ) -> Result<Box<dyn Plant>, PlantError> {
        let Self { kind, substeps } = *self;
        Ok(match kind.engine() {
            Some(engine) => Box::new(RapierPlant::new(mechanism, start, dt_s, substeps, engine)?),
            None => Box::new(ArticulatedPlant::new(mechanism, start, dt_s, substeps)?),
        })
    }

    /// What the plant is, for reports.
    pub fn description(&self) -> Description {
        match self.kind.engine() {
            Some(engine) => engine.description(self.substeps),
            None => ArticulatedPlant::description(self.substeps),
        }
    }
}

impl PlantKind {
    /// What is set of the game engine, if it is that.
    fn engine(self) -> Option<EngineSettings> {
        match self {
            Self::Rapier => Some(EngineSettings::TORQUE_CONTROL),
            Self::RapierGyroscopic => Some(EngineSettings::GYROSCOPIC),
            Self::RapierDefaults => Some(EngineSettings::DEFAULTS),
            Self::Articulated => None,
        }
    }
}

/// Where a body is and how it moves, world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingPose {
    /// Its pose.
    pub pose: Pose,
    /// Angular velocity in rad/s.
    pub angular_rad_s: DVec3,
    /// Velocity of the frame's origin in m/s.
    pub linear_m_s: DVec3,
}

/// A body without a name on a joint in its parent's axes, at `position_m` in its parent's frame: without friction,
/// ranges, limits or rotor.
pub fn link(
    parent: Option<usize>,
    joint: JointModel,
    position_m: DVec3,
    mass: &MassProperties,
) -> Link {
    Link {
        mass_kg: mass.mass_kg,
        center_of_mass_m: mass.center_of_mass_m,
        inertia_kg_m2: mass.rotational_kg_m2,
        ..Link::on(parent, joint, position_m)
    }
}

/// What the drives do during one step, world axes. What a joint cannot follow, its bearings carry: of a hinge the
/// torque about its axis counts, of a slide the force along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Torque of joint `i` on body `i`, in N m. Its reaction acts on the parent; the root's comes from
    /// outside.
    pub torque_nm: Vec<DVec3>,
    /// Force of joint `i` on body `i` at the origin of its frame, in N: of slides, and of a joint that leaves all free.
    pub force_n: Vec<DVec3>,
}

impl Drive {
    /// No force and no torque on so many bodies.
    pub fn none(bodies: usize) -> Self {
        Self { torque_nm: vec![DVec3::ZERO; bodies], force_n: vec![DVec3::ZERO; bodies] }
    }
}

/// A simulated mechanism that is driven by torques and gives its poses, nothing else: velocities are for
/// the controller to find.
pub trait Plant {
    /// Advances by one step with the drives held.
    fn step(&mut self, drive: &Drive);

    /// Poses of all bodies, by body.
    fn poses(&self) -> &[Pose];
}

/// What a plant is, for reports.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Description {
    /// Short name.
    pub name: &'static str,
    /// The program that computes it.
    pub engine: &'static str,
    /// What is set otherwise than by default.
    pub settings: Settings,
}

/// How a plant computes a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// How velocities and poses follow from accelerations.
    pub integrator: &'static str,
    /// Equal parts that a step is cut in, with the torques held.
    pub substeps: usize,
    /// Sweeps of the constraint solver in each of them, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver_sweeps: Option<usize>,
    /// Where the gyroscopic torque comes from.
    pub gyroscopic_term: &'static str,
    /// Whether bodies touch.
    pub contacts: bool,
}

impl fmt::Display for Description {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { engine, settings, .. } = self;
        write!(f, "{engine}, {} substep(s)", settings.substeps)?;
        if let Some(sweeps) = settings.solver_sweeps {
            write!(f, " of {sweeps} solver sweeps")?;
        }
        write!(
            f,
            ", gyroscopic term {}, {} contacts",
            settings.gyroscopic_term,
            if settings.contacts { "with" } else { "no" },
        )
    }
}
