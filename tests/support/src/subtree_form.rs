//! Another algorithm for the nearest pose: each body is turned alone, and its subtree moves along rigidly.
//!
//! First the root moves by the mean of all residuals. Then, from parents to children, a body's turn `d` in world axes
//! solves `(w 1 + Σ n_c (|l_c|² 1 - l_c l_cᵀ)) d = -w θ + Σ l_c × s_c`, with sums over its children: `l_c` is the
//! child's offset, `n_c` the number of bodies from it outwards, `s_c` the sum of their residuals, `θ` the turn of the
//! body from its desired orientation, and `w` the weight of a squared turn in m².

use sinew_core::glam::{Mat3, Quat, Vec3};
use sinew_core::{Transform, Tree, math};

/// The algorithm, with its state from the last frame.
#[derive(Debug, Clone)]
pub struct SubtreeForm {
    /// Deviation of each body, in its desired axes.
    deviations: Vec<Quat>,
    root_shift_m: Vec3,
    rotation_weight_m2: f32,
    counts: Vec<f32>,
}

impl SubtreeForm {
    /// Creates the algorithm for a tree. Every position has weight 1; `rotation_m` is the weight of rotations.
    pub fn new<const N: usize>(tree: &Tree<N>, rotation_m: f32) -> Self {
        Self {
            deviations: vec![Quat::IDENTITY; tree.len()],
            root_shift_m: Vec3::ZERO,
            rotation_weight_m2: rotation_m * rotation_m,
            counts: (0..tree.len()).map(|body| tree.subtree(body).len() as f32).collect(),
        }
    }

    /// Returns the poses of all joints in their parents' frames, for a tree of spherical joints with a free root.
    pub fn project<const N: usize>(
        &mut self,
        tree: &Tree<N>,
        desired: &[Transform],
        sweeps: usize,
        out: &mut [Transform],
    ) {
        let bodies = tree.bodies();
        let (mut wanted, mut poses) = ([Transform::IDENTITY; N], [Transform::IDENTITY; N]);
        let (mut sums, mut moved) = ([Vec3::ZERO; N], [Vec3::ZERO; N]);
        for (index, (body, joint)) in bodies.iter().zip(desired).enumerate() {
            wanted[index] = body.parent.map_or(*joint, |parent| wanted[parent] * *joint);
        }
        for _ in 0..sweeps {
            for (index, body) in bodies.iter().enumerate() {
                let rotation = math::unit(wanted[index].rotation * self.deviations[index]);
                let translation_m = body.parent.map_or_else(
                    || wanted[0].translation_m + self.root_shift_m,
                    |parent| poses[parent].transform_point(body.placement.translation_m),
                );
                poses[index] = Transform { rotation, translation_m };
                sums[index] = wanted[index].translation_m - translation_m;
            }
            for (index, body) in bodies.iter().enumerate().rev() {
                if let Some(parent) = body.parent {
                    let sum = sums[index];
                    sums[parent] += sum;
                }
            }
            let shift = sums[0] / self.counts[0];
            self.root_shift_m += shift;
            moved[0] = shift;
            for index in 0..bodies.len() {
                let turned = wanted[index].rotation * self.deviations[index];
                let theta = math::log(turned * wanted[index].rotation.conjugate());
                let mut left = Mat3::from_diagonal(Vec3::splat(self.rotation_weight_m2));
                let mut right = theta * -self.rotation_weight_m2;
                for child in tree.children(index).iter() {
                    let arm = poses[child].translation_m - poses[index].translation_m;
                    let outer = Mat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
                    let square = Mat3::from_diagonal(Vec3::splat(arm.dot(arm)));
                    left += (square - outer) * self.counts[child];
                    // The bodies nearer to the root have already moved.
                    right += arm.cross(sums[child] - moved[index] * self.counts[child]);
                }
                let turn = math::exp(left.inverse() * right);
                self.deviations[index] =
                    math::unit(wanted[index].rotation.conjugate() * (turn * turned));
                for child in tree.children(index).iter() {
                    let arm = poses[child].translation_m - poses[index].translation_m;
                    moved[child] = moved[index] + (turn * arm - arm);
                }
            }
        }
        for (index, body) in bodies.iter().enumerate() {
            let rotation = math::unit(wanted[index].rotation * self.deviations[index]);
            poses[index].rotation = rotation;
            out[index] = match body.parent {
                None => Transform::new(rotation, wanted[0].translation_m + self.root_shift_m),
                Some(parent) => Transform {
                    rotation: math::unit(poses[parent].rotation.conjugate() * rotation),
                    ..body.placement
                },
            };
        }
    }
}
