//! Plants: simulated mechanisms that are controlled through one trait.

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

pub use articulated::{Accelerations, ArticulatedPlant, LANES};
pub use check::PlantError;
pub use check::check_link;
pub use mass_properties::MassProperties;
pub use rapier::{EngineSettings, RapierPlant};
pub use sinew_rig::mechanism::GRAVITY_M_S2;
pub use sinew_rig::mechanism::{JointModel, Link, Mechanism, Pose};

/// Choice of the plant, and of its substeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PlantSettings {
    /// Kind of plant.
    pub kind: PlantKind,
    /// Number of equal parts of a step, with constant torques; at least 1. An engine may divide them further.
    pub substeps: usize,
}

impl Default for PlantSettings {
    fn default() -> Self {
        Self { kind: PlantKind::Rapier, substeps: 1 }
    }
}

/// The available plants.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
#[value(rename_all = "snake_case")]
pub enum PlantKind {
    /// The game engine rapier in maximal coordinates, set up for torque control.
    Rapier,
    /// rapier as above, but with the engine's own gyroscopic term.
    RapierGyroscopic,
    /// rapier with its default settings: it divides each of our substeps into 4 of its own.
    RapierDefaults,
    /// Exact dynamics in reduced coordinates: joints cannot drift.
    Articulated,
}

impl PlantSettings {
    /// Builds the mechanism in the given state. `start` has one state per body; the poses must fit the joints.
    ///
    /// # Errors
    /// [`PlantError`] if the mechanism, its state, the step or the substeps are invalid, or the engine does not
    /// simulate a joint or a body or does not reproduce a body's inertia.
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

    /// Returns a description of the plant, for reports.
    pub fn description(&self) -> Description {
        match self.kind.engine() {
            Some(engine) => engine.description(self.substeps),
            None => ArticulatedPlant::description(self.substeps),
        }
    }
}

impl PlantKind {
    /// Returns the settings of the game engine; `None` for another plant.
    fn engine(self) -> Option<EngineSettings> {
        match self {
            Self::Rapier => Some(EngineSettings::TORQUE_CONTROL),
            Self::RapierGyroscopic => Some(EngineSettings::GYROSCOPIC),
            Self::RapierDefaults => Some(EngineSettings::DEFAULTS),
            Self::Articulated => None,
        }
    }
}

/// Pose and velocity of a body, world axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MovingPose {
    /// Pose of the body.
    pub pose: Pose,
    /// Angular velocity in rad/s.
    pub angular_rad_s: DVec3,
    /// Velocity of the frame's origin in m/s.
    pub linear_m_s: DVec3,
}

/// Returns a body without a name, on a joint in its parent's axes at `position_m` in its parent's frame, without
/// friction, ranges, limits or rotor.
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

/// Efforts of the drives during one step, world axes. A hinge uses only the torque about its axis, a slide only the
/// force along its axis; their bearings carry the other components.
#[derive(Debug, Clone, PartialEq)]
pub struct Drive {
    /// Torque of joint `i` on body `i`, in N m. Its reaction acts on the parent; the root's torque is external.
    pub torque_nm: Vec<DVec3>,
    /// Force of joint `i` on body `i` at the origin of its frame, in N. Only slides and free joints use it.
    pub force_n: Vec<DVec3>,
}

impl Drive {
    /// Returns a drive without force and torque for `bodies` bodies.
    pub fn none(bodies: usize) -> Self {
        Self { torque_nm: vec![DVec3::ZERO; bodies], force_n: vec![DVec3::ZERO; bodies] }
    }
}

/// A simulated mechanism that is driven by torques and provides only its poses. The controller has to estimate
/// velocities itself.
pub trait Plant {
    /// Advances the simulation by one step with constant drives.
    fn step(&mut self, drive: &Drive);

    /// Returns the poses of all bodies, by body.
    fn poses(&self) -> &[Pose];

    /// Returns the exact plant, which can take its steps together with others; `None` for another plant.
    fn as_articulated(&self) -> Option<&ArticulatedPlant> {
        None
    }
}

/// The description of a plant, for reports.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Description {
    /// Short name of the plant.
    pub name: &'static str,
    /// Program that computes the plant.
    pub engine: &'static str,
    /// Settings that differ from the defaults.
    pub settings: Settings,
}

/// The method by which a plant computes a step.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Settings {
    /// Method of integration from accelerations to velocities and poses.
    pub integrator: &'static str,
    /// Number of equal parts of a step, with constant torques.
    pub substeps: usize,
    /// Number of sweeps of the constraint solver in each part, if there is a solver.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub solver_sweeps: Option<usize>,
    /// Source of the gyroscopic torque.
    pub gyroscopic_term: &'static str,
    /// Whether bodies collide.
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
