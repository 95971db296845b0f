//! Cases of `errors/1` as they are in the file, and with rounding.

use serde::Deserialize;
use sinew_core::{BodyState, Transform, Twist};

use crate::error::CaseError;
use crate::golden::{Rotation, Scalar, Vector, expect_count};
use crate::rounding::{self, Motion, State};

#[derive(Deserialize)]
pub(crate) struct Case {
    pub(super) n: usize,
    pub(super) parent: Vec<i64>,
    pub(super) leaf: Vec<bool>,
    pub(super) aim: Vec<Vector>,
    pub(super) aim_child: Vec<i64>,
    pub(super) desired: States,
    pub(super) measured: States,
    pub(super) expected: Expected,
}

/// States of all bodies in the world.
#[derive(Deserialize)]
pub(super) struct States {
    pub(super) pos: Vec<Vector>,
    pub(super) quat: Vec<Rotation>,
    pub(super) lin_vel: Vec<Vector>,
    pub(super) ang_vel: Vec<Vector>,
}

#[derive(Deserialize)]
pub(super) struct Expected {
    pub(super) local: Vec<Difference>,
    pub(super) world: Vec<Difference>,
    pub(super) egocentric: Vec<Difference>,
    pub(super) grandparent: Grandparent,
    pub(super) linear_compensation: Vec<Compensated>,
    pub(super) metrics: Metrics,
}

#[derive(Deserialize)]
pub(super) struct Grandparent {
    pub(super) frame: Vec<i64>,
    pub(super) error: Vec<Difference>,
}

#[derive(Deserialize)]
pub(super) struct Metrics {
    pub(super) angular_deg: Statistics,
    pub(super) linear_cm: Statistics,
}

#[derive(Deserialize)]
pub(super) struct Statistics {
    pub(super) mean_all: Scalar,
    pub(super) max_all: Scalar,
    pub(super) mean_leaf: Scalar,
    pub(super) max_leaf: Scalar,
}

impl States {
    pub(super) fn with_rounding(&self) -> Vec<State> {
        let given = rounding::Vector::given;
        let state = |body: usize| State {
            rotation: rounding::Rotation::given(self.quat[body].0),
            position: given(self.pos[body].0),
            velocity: Motion {
                angular: given(self.ang_vel[body].0),
                linear: given(self.lin_vel[body].0),
            },
        };
        (0..self.quat.len()).map(state).collect()
    }

    pub(super) fn rounded(&self, side: &str, n: usize) -> Result<Vec<BodyState>, CaseError> {
        expect_count(&format!("{side}.quat"), self.quat.len(), n)?;
        let vectors = [("pos", &self.pos), ("lin_vel", &self.lin_vel), ("ang_vel", &self.ang_vel)];
        for (field, list) in vectors {
            expect_count(&format!("{side}.{field}"), list.len(), n)?;
        }
        let state = |body: usize| BodyState {
            pose: Transform::new(self.quat[body].rounded(), self.pos[body].rounded()),
            velocity: Twist::new(self.ang_vel[body].rounded(), self.lin_vel[body].rounded()),
        };
        Ok((0..n).map(state).collect())
    }
}

/// A state error as in the files.
#[derive(Deserialize, Clone, Copy)]
pub(super) struct Difference {
    pub(super) e_rot: Vector,
    pub(super) e_lin: Vector,
    pub(super) ed_rot: Vector,
    pub(super) ed_lin: Vector,
}

/// Errors of all bodies for one weight β.
#[derive(Deserialize)]
pub(super) struct Compensated {
    pub(super) beta: Scalar,
    pub(super) error: Vec<CompensatedBody>,
}

#[derive(Deserialize)]
pub(super) struct CompensatedBody {
    #[serde(flatten)]
    pub(super) difference: Difference,
    pub(super) status: Status,
    pub(super) phi: Vector,
    pub(super) theta_prime: Rotation,
    pub(super) z: Option<Vector>,
    pub(super) tip_error: Option<TipError>,
}

#[derive(Deserialize, Clone, Copy, PartialEq)]
#[serde(rename_all = "snake_case")]
pub(super) enum Status {
    Leaf,
    Ok,
    Parallel,
    Antiparallel,
    Coincident,
    ZeroAim,
}

/// Error of the tip for the core's rotation; the file also contains two other rotations for comparison.
#[derive(Deserialize)]
pub(super) struct TipError {
    pub(super) theta_prime: Scalar,
}

impl CompensatedBody {
    /// Returns whether there are two directions between which the body is turned.
    pub(super) fn is_turned(&self) -> bool {
        matches!(self.status, Status::Ok | Status::Parallel | Status::Antiparallel)
    }
}
