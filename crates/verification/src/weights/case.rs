//! Cases of `weights/1` as they are in the file.

use serde::Deserialize;

use crate::golden::{Scalar, Vector};

#[derive(Deserialize)]
pub(crate) struct Case {
    pub(super) parent: Vec<i64>,
    pub(super) pos: Vec<Vector>,
    pub(super) radius: Vec<Scalar>,
    pub(super) descendant_matrix: Vec<Vec<u8>>,
    pub(super) descendants_length: Vec<Lengths>,
    pub(super) cylinder_exact: Cylinders,
    pub(super) cylinder_sampled: Samples,
    pub(super) mesh: Mesh,
}

/// Weights before and after normalization to a sum of 1.
#[derive(Deserialize)]
pub(super) struct Expected {
    pub(super) raw: Vec<f64>,
    pub(super) normalised: Vec<f64>,
}

#[derive(Deserialize)]
pub(super) struct Lengths {
    pub(super) base: Scalar,
    pub(super) discount: Scalar,
    #[serde(flatten)]
    pub(super) expected: Expected,
}

#[derive(Deserialize)]
pub(super) struct Cylinders {
    pub(super) base: Scalar,
    #[serde(flatten)]
    pub(super) expected: Expected,
}

#[derive(Deserialize)]
pub(super) struct Samples {
    pub(super) base: Scalar,
    /// Sample points, used for every bone.
    pub(super) uv: Vec<[Scalar; 2]>,
    #[serde(flatten)]
    pub(super) expected: Expected,
}

#[derive(Deserialize)]
pub(super) struct Mesh {
    pub(super) base: Scalar,
    pub(super) vertices: Vec<Vector>,
    pub(super) vertex_area: Vec<Scalar>,
    /// Joints of each vertex. The next field contains their skinning weights.
    pub(super) bind: Vec<Vec<usize>>,
    pub(super) weight: Vec<Vec<Scalar>>,
    #[serde(flatten)]
    pub(super) expected: Expected,
}
