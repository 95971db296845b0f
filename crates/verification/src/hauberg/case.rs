//! Cases of `hauberg/1` as they are in the file.

use glam::DQuat;
use serde::Deserialize;
use sinew_core::projection::JointRange;
use sinew_core::{Body, Inertia, JointKind, Transform, Tree};
use sinew_pose_metrics::geodesic::{Rig, RigJoint};

use crate::error::CaseError;
use crate::golden::Vector;

/// Largest capacity of the core.
pub(super) const CAPACITY: usize = 128;

#[derive(Deserialize)]
#[expect(non_snake_case, reason = "as in the files")]
pub(crate) struct Case {
    pub(super) parent: Vec<i64>,
    pub(super) offset: Vec<Vector>,
    pub(super) N: u16,
    pub(super) theta0: Vec<Vector>,
    pub(super) theta1: Vec<Vector>,
    pub(super) F0: Vec<f64>,
    pub(super) F1: Vec<f64>,
    pub(super) joint_angle_distance: f64,
    pub(super) so3_distance: f64,
    pub(super) chord: f64,
    pub(super) line: GoldenLine,
    pub(super) slerp_line: Length,
    pub(super) geodesic: Geodesic,
    pub(super) ratio_slerp: f64,
}

#[derive(Deserialize)]
pub(super) struct GoldenLine {
    pub(super) energy: f64,
    pub(super) length: f64,
    pub(super) gradient_rotvec: Vec<Vec<Vector>>,
    pub(super) gradient_tangent_body: Vec<Vec<Vector>>,
    pub(super) theta_mid: Vec<Vector>,
    #[serde(rename = "F_mid")]
    pub(super) f_mid: Vec<f64>,
}

#[derive(Deserialize)]
pub(super) struct Length {
    pub(super) energy: f64,
    pub(super) length: f64,
}

#[derive(Deserialize)]
pub(super) struct Geodesic {
    pub(super) energy: f64,
    pub(super) length: f64,
    #[serde(rename = "F")]
    pub(super) f: Vec<Vec<f64>>,
}

impl Case {
    pub(super) fn parent(&self, joint: usize) -> Option<usize> {
        usize::try_from(self.parent[joint]).ok()
    }

    pub(super) fn tree(&self) -> Result<Tree<CAPACITY>, CaseError> {
        let bodies: Vec<Body> = (0..self.parent.len())
            .map(|joint| Body {
                parent: self.parent(joint),
                joint: kind(joint),
                placement: Transform::from_translation(self.offset[joint].rounded()),
                inertia: Inertia::default(),
                rotor_inertia: 0.0,
            })
            .collect();
        Tree::from_bodies(&bodies).map_err(|error| CaseError::new("parent", error))
    }

    pub(super) fn rig(&self) -> Result<Rig, CaseError> {
        let joints: Vec<RigJoint> = (0..self.parent.len())
            .map(|joint| RigJoint {
                parent: self.parent(joint),
                kind: kind(joint),
                rotation: DQuat::IDENTITY,
                offset_m: self.offset[joint].0,
                range: JointRange::Any,
                weight: 1.0,
            })
            .collect();
        Rig::new(&joints).map_err(|error| CaseError::new("parent", error))
    }
}

/// Returns the kind of a joint: the root is fixed, all other joints are spherical.
pub(super) fn kind(joint: usize) -> JointKind {
    if joint == 0 { JointKind::Fixed } else { JointKind::Spherical }
}
