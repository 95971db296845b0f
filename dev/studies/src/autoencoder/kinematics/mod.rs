//! Differentiable forward kinematics: from local rotations as two columns to global positions and rotations.
//!
//! Input: `[poses, 6 joints]`, two columns per joint. Output: `[poses, 9 joints]`, per joint its position in metres
//! with the root at the origin, and the two columns of its global rotation.

mod fused;
mod layout;
mod tensors;

use candle_core::{Result, Tensor};
use serde::Serialize;

use fused::Fused;
pub(super) use layout::NUMBERS;
use sinew_mocap::Skeleton;
use tensors::Tensors;

/// Implementation of forward kinematics: the results are the same, the times differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Form {
    /// Tensor operations on one joint of all poses after the other.
    ByJoint,
    /// Tensor operations on all joints of one depth in the tree.
    ByLevel,
    /// One operation with its own gradient.
    Fused,
}

impl Form {
    /// All forms, the slowest first.
    pub const ALL: [Self; 3] = [Self::ByJoint, Self::ByLevel, Self::Fused];

    /// Returns the form's name in tables.
    pub const fn label(self) -> &'static str {
        match self {
            Self::ByJoint => "joint by joint",
            Self::ByLevel => "level by level",
            Self::Fused => "one operation",
        }
    }
}

/// Forward kinematics of one skeleton.
#[derive(Debug, Clone)]
pub(super) enum Kinematics {
    Tensors(Tensors),
    Fused(Fused),
}

impl Kinematics {
    pub(super) fn new(skeleton: &Skeleton, form: Form) -> Result<Self> {
        let depth = depths(skeleton);
        let groups: Vec<Vec<usize>> = match form {
            Form::Fused => return Ok(Self::Fused(Fused::new(skeleton))),
            Form::ByJoint => (0..skeleton.joints.len()).map(|joint| vec![joint]).collect(),
            Form::ByLevel => (0..=depth.iter().copied().max().unwrap_or(0))
                .map(|level| (0..depth.len()).filter(|joint| depth[*joint] == level).collect())
                .collect(),
        };
        Ok(Self::Tensors(Tensors::new(skeleton, &groups)?))
    }

    pub(super) fn global(&self, columns: &Tensor) -> Result<Tensor> {
        match self {
            Self::Tensors(tensors) => tensors.global(columns),
            Self::Fused(fused) => columns.apply_op1(fused.clone()),
        }
    }
}

/// Returns the depth of each joint in the tree.
fn depths(skeleton: &Skeleton) -> Vec<usize> {
    let mut depths: Vec<usize> = Vec::new();
    for joint in &skeleton.joints {
        depths.push(joint.parent.map_or(0, |parent| depths[parent] + 1));
    }
    depths
}

#[cfg(test)]
mod tests;
