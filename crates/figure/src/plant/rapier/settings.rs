//! Settings of the game engine rapier.

use crate::plant::{Description, Settings};

/// The settings of the game engine rapier that differ between the plants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineSettings {
    name: &'static str,
    /// The engine's `num_solver_iterations`, the number of parts into which it divides each of the plant's
    /// substeps.
    pub(super) solver_iterations: usize,
    /// The engine's `num_internal_pgs_iterations`: sweeps of the constraint solver in each of these parts.
    pub(super) sweeps: usize,
    /// Source of the gyroscopic torque `-ω × I ω`.
    pub(super) gyroscopic_term: GyroscopicTerm,
    /// Whether a body may turn by more than 45 degrees in a step.
    pub(super) fast_rotation: bool,
}

/// The part of the program that adds the gyroscopic torque `-ω × I ω` of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GyroscopicTerm {
    /// The plant adds it, at the velocity for which the torques were computed.
    Plant,
    /// The engine adds it, at a velocity that the torques have changed and the joints have not yet corrected.
    Engine,
}

impl EngineSettings {
    /// Settings for torques that cancel the dynamics at the same instant. The engine's defaults are made for
    /// contacts and stacks instead.
    ///
    /// The engine does not divide the step, since the torques are right only at its start. With one sweep, the
    /// engine's default, the simulation then diverges; with 4 or more sweeps the results agree in three digits.
    pub const TORQUE_CONTROL: Self = Self {
        name: "rapier",
        solver_iterations: 1,
        sweeps: 8,
        gyroscopic_term: GyroscopicTerm::Plant,
        fast_rotation: true,
    };

    /// [`TORQUE_CONTROL`](Self::TORQUE_CONTROL) with the engine's own gyroscopic term, to show the effect of that
    /// term alone.
    pub const GYROSCOPIC: Self = Self {
        name: "rapier_gyroscopic",
        gyroscopic_term: GyroscopicTerm::Engine,
        ..Self::TORQUE_CONTROL
    };

    /// The engine's default settings, except that bodies at rest do not sleep.
    pub const DEFAULTS: Self = Self {
        name: "rapier_defaults",
        solver_iterations: 4,
        sweeps: 1,
        gyroscopic_term: GyroscopicTerm::Engine,
        fast_rotation: false,
    };

    /// Returns a description of a plant with these settings.
    pub const fn description(&self, substeps: usize) -> Description {
        Description {
            name: self.name,
            // The version that Cargo.toml pins.
            engine: "rapier3d-f64 0.36.1",
            settings: Settings {
                integrator: "semi-implicit Euler, rotations linearised",
                substeps: substeps * self.solver_iterations,
                solver_sweeps: Some(self.sweeps),
                gyroscopic_term: match self.gyroscopic_term {
                    GyroscopicTerm::Plant => "explicit",
                    GyroscopicTerm::Engine => "the engine's",
                },
                contacts: false,
            },
        }
    }
}
