//! Cases of `rnea/1` as they are in the file.

use glam::DVec3;
use serde::Deserialize;

use crate::figure::{GoldenBody, Root};
use crate::golden::{Rotation, Scalar, Vector};

#[derive(Deserialize)]
pub(crate) struct Case {
    pub(super) n: usize,
    pub(super) root: Root,
    pub(super) gravity: Vector,
    pub(super) bodies: Vec<GoldenBody>,
    pub(super) states: Vec<State>,
}

#[derive(Deserialize)]
pub(super) struct State {
    pub(super) kind: String,
    pub(super) quat: Vec<Rotation>,
    pub(super) omega: Vec<Vector>,
    pub(super) alpha: Vec<Vector>,
    #[serde(flatten)]
    pub(super) root: Option<RootMotion>,
    pub(super) tau: Vec<Vector>,
    pub(super) bias: Vec<Vector>,
    pub(super) gravity_term: Vec<Vector>,
    pub(super) root_wrench: RootWrench,
    #[serde(rename = "H_lower")]
    pub(super) mass_matrix_lower: Option<Vec<Scalar>>,
    pub(super) world: Option<Vec<WorldState>>,
}

/// Fields that exist only for a free root.
#[derive(Deserialize, Clone, Copy)]
pub(super) struct RootMotion {
    pub(super) root_pos: Vector,
    pub(super) root_lin_vel_body: Vector,
    pub(super) root_lin_vel_world: Vector,
    pub(super) root_lin_acc_world: Vector,
    pub(super) bias_root_force_body: Vector,
    pub(super) gravity_root_force_body: Vector,
}

#[derive(Deserialize)]
pub(super) struct RootWrench {
    pub(super) moment_body: Vector,
    pub(super) force_body: Vector,
    pub(super) moment_world_about_origin0: Vector,
    pub(super) force_world: Vector,
}

#[derive(Deserialize)]
pub(super) struct WorldState {
    pub(super) pos: Vector,
    pub(super) quat: Rotation,
    pub(super) omega: Vector,
    pub(super) vel: Vector,
}

/// Returns the accelerations of the joints, angular and linear. In the core, a free root's acceleration is
/// classical: the world acceleration is rotated to body axes.
pub(super) fn accelerations(state: &State) -> Vec<[DVec3; 2]> {
    let mut motions: Vec<_> = state.alpha.iter().map(|alpha| [alpha.0, DVec3::ZERO]).collect();
    if let Some(root) = &state.root {
        motions[0][1] = state.quat[0].0.inverse() * root.root_lin_acc_world.0;
    }
    motions
}

/// Returns the accelerations that are zero in the files' coordinates. For a free root the derivative of the
/// velocity's components in body axes is zero, but the classical acceleration is not.
pub(super) fn bias_accelerations(state: &State) -> Vec<[DVec3; 2]> {
    let mut motions = vec![[DVec3::ZERO; 2]; state.alpha.len()];
    if let Some(root) = &state.root {
        motions[0][1] = state.omega[0].0.cross(root.root_lin_vel_body.0);
    }
    motions
}
