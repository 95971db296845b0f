//! What is set of the engine.

use crate::plant::{Description, Settings};

/// What is set of the engine.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineSettings {
    name: &'static str,
    /// The engine's `num_solver_iterations`, by which it cuts a step: in each of the plant's substeps.
    pub(super) solver_iterations: usize,
    /// The engine's `num_internal_pgs_iterations`: sweeps of the constraint solver in each of them.
    pub(super) sweeps: usize,
    /// Who adds `-ω × I ω`.
    pub(super) gyroscopic_term: GyroscopicTerm,
    /// Whether a body may turn by more than 45 degrees a step.
    pub(super) fast_rotation: bool,
}

/// Who adds the gyroscopic torque `-ω × I ω` of a body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum GyroscopicTerm {
    /// The plant, at the velocity that the torques were computed for.
    Plant,
    /// The engine, at a velocity that the torques have changed and the joints have not corrected yet.
    Engine,
}

impl EngineSettings {
    /// For torques that cancel the dynamics of the same instant: not the engine's defaults, which are made
    /// for contacts and stacks.
    ///
    /// The step is not cut, since the torques hold for its start only. With one sweep, the engine's default,
    /// it then diverges; from 4 sweeps on the results agree in three digits.
    pub const TORQUE_CONTROL: Self = Self {
        name: "rapier",
        solver_iterations: 1,
        sweeps: 8,
        gyroscopic_term: GyroscopicTerm::Plant,
        fast_rotation: true,
    };

    /// The same with the engine's own gyroscopic term, to show what that alone does.
    pub const GYROSCOPIC: Self = Self {
        name: "rapier_gyroscopic",
        gyroscopic_term: GyroscopicTerm::Engine,
        ..Self::TORQUE_CONTROL
    };

    /// As the engine comes, but that bodies at rest do not sleep.
    pub const DEFAULTS: Self = Self {
        name: "rapier_defaults",
        solver_iterations: 4,
        sweeps: 1,
        gyroscopic_term: GyroscopicTerm::Engine,
        fast_rotation: false,
    };

    /// What a plant with these settings is.
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
