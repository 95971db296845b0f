//! Weights of joints with their rounding.

use std::f64::consts::TAU;

use super::case::{Case, Lengths, Mesh};
use crate::golden::Scalar;
use crate::rounding::{Number, Vector};

/// A skeleton with its rounding.
pub(super) struct Rounded<'a> {
    parents: &'a [Option<usize>],
    positions: Vec<Vector>,
    radii: Vec<Number>,
}

impl<'a> Rounded<'a> {
    pub(super) fn new(case: &Case, parents: &'a [Option<usize>]) -> Self {
        Self {
            parents,
            positions: case.pos.iter().map(|position| Vector::given(position.0)).collect(),
            radii: case.radius.iter().map(|radius| Number::given(radius.0)).collect(),
        }
    }

    fn start(&self, base: Scalar) -> Vec<Number> {
        vec![Number::given(base.0); self.parents.len()]
    }

    /// Returns a joint's ancestors, the nearest first.
    fn ancestors(&self, joint: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(self.parents[joint], |joint| self.parents[*joint])
    }

    /// Returns the joints from the leaves inwards, since parents may have any index in a file.
    fn inwards(&self) -> Vec<usize> {
        let mut joints: Vec<_> = (0..self.parents.len()).collect();
        joints.sort_by_key(|joint| std::cmp::Reverse(self.ancestors(*joint).count()));
        joints
    }

    pub(super) fn by_length(&self, lengths: &Lengths) -> Vec<Number> {
        let mut weights = self.start(lengths.base);
        let discount = Number::given(lengths.discount.0);
        for joint in self.inwards() {
            let Some(parent) = self.parents[joint] else { continue };
            let length = (self.positions[joint] - self.positions[parent]).length();
            weights[parent] = weights[parent] + discount * (length + weights[joint]);
        }
        weights
    }

    /// Computes the weights from a few points of the surface, which represent all: the mean rounding of more
    /// points, or of a quadrature, is smaller.
    pub(super) fn by_surface(&self, base: Scalar) -> Vec<Number> {
        let mut weights = self.start(base);
        for joint in 0..self.parents.len() {
            let Some(parent) = self.parents[joint] else { continue };
            let along = self.positions[joint] - self.positions[parent];
            let length = along.length();
            if length.exact() <= 0.0 || self.radii[joint].exact() <= 0.0 {
                continue;
            }
            let axis = along * (Number::known(1.0) / length);
            let across = axis.cross(Vector::given(axis.exact().any_orthonormal_vector()));
            let across = [across, axis.cross(across)].map(|across| across * self.radii[joint]);
            let area = Number::given(TAU) * self.radii[joint] * length;
            let points = [0.25, 0.5, 0.75]
                .into_iter()
                .flat_map(|u| (0..4).map(move |quarter| (u, f64::from(quarter) * TAU / 4.0 + u)));
            let part = area * (Number::known(1.0) / Number::known(12.0));
            for (u, angle) in points {
                let point = self.positions[parent]
                    + axis * (Number::given(u) * length)
                    + across[0] * Number::given(angle.cos())
                    + across[1] * Number::given(angle.sin());
                for ancestor in self.ancestors(joint) {
                    let distance = (point - self.positions[ancestor]).length();
                    weights[ancestor] = weights[ancestor] + part * distance;
                }
            }
        }
        weights
    }

    pub(super) fn by_mesh(&self, mesh: &Mesh) -> Vec<Number> {
        let mut weights = self.start(mesh.base);
        for (vertex, position) in mesh.vertices.iter().enumerate() {
            let (position, area) =
                (Vector::given(position.0), Number::given(mesh.vertex_area[vertex].0));
            let shares: Vec<_> =
                mesh.weight[vertex].iter().map(|weight| Number::given(weight.0)).collect();
            let sum = shares.iter().fold(Number::ZERO, |sum, share| sum + *share);
            for (joint, share) in mesh.bind[vertex].iter().zip(shares) {
                let share = area * (share / sum);
                for moved_by in std::iter::once(*joint).chain(self.ancestors(*joint)) {
                    let distance = (position - self.positions[moved_by]).length();
                    weights[moved_by] = weights[moved_by] + share * distance;
                }
            }
        }
        weights
    }
}
