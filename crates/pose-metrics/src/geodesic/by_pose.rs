//! Newton's step, eliminated pose by pose: the matrix is block-tridiagonal, and is solved by Cholesky factors of
//! its blocks.

use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::pose_model::PoseModel;
use super::rig::{Rig, RigPose};

/// The matrix of second derivatives, without the additions to its diagonal.
pub(super) struct Blocks {
    diagonal: Vec<DMatrix<f64>>,
    above: Vec<DMatrix<f64>>,
    /// Diagonal blocks without second derivatives of positions.
    convex: Vec<DMatrix<f64>>,
}

impl Blocks {
    pub(super) fn new(
        rig: &Rig,
        placed: &[RigPose],
        poses: &[PoseModel],
        has_second_derivatives: bool,
    ) -> Self {
        let jacobians: Vec<_> = placed.iter().map(|at| rig.jacobian(at)).collect();
        let mut blocks = Self { diagonal: Vec::new(), above: Vec::new(), convex: Vec::new() };
        for (k, (at, pose)) in placed.iter().zip(poses).enumerate() {
            let jacobian = &jacobians[k];
            let mut convex = jacobian.tr_mul(jacobian) * 4.0;
            for (index, barrier) in pose.barrier.iter().enumerate() {
                convex[(index, index)] += barrier;
            }
            let mut diagonal = convex.clone();
            if has_second_derivatives {
                diagonal += rig.bend(at, &pose.pull);
            }
            if k > 0 {
                blocks.above.push(jacobians[k - 1].tr_mul(jacobian) * -2.0);
            }
            blocks.diagonal.push(diagonal);
            blocks.convex.push(convex);
        }
        blocks
    }

    /// Returns the step of each pose, with `added` on the diagonal; `None` if the matrix is not positive definite.
    pub(super) fn solve(
        &self,
        bends: bool,
        added: &[DVector<f64>],
        poses: &[PoseModel],
    ) -> Option<Vec<DVector<f64>>> {
        let blocks = if bends { &self.diagonal } else { &self.convex };
        let mut diagonal = blocks.clone();
        for (block, added) in diagonal.iter_mut().zip(added) {
            for (index, added) in added.iter().enumerate() {
                block[(index, index)] += added;
            }
        }
        let right: Vec<_> = poses.iter().map(|pose| pose.downhill.clone()).collect();
        solve(&diagonal, &self.above, &right)
    }
}

/// Solves `A x = b` for a symmetric positive definite block-tridiagonal matrix: `diagonal` contains the diagonal
/// blocks, `above[k]` is the block in row k, column k + 1. `None` if the matrix is not positive definite. O(blocks
/// · size³).
fn solve(
    diagonal: &[DMatrix<f64>],
    above: &[DMatrix<f64>],
    right: &[DVector<f64>],
) -> Option<Vec<DVector<f64>>> {
    let mut factors: Vec<Cholesky<f64, Dyn>> = Vec::with_capacity(diagonal.len());
    // L⁻¹ of the previous factor times the block above the diagonal: the transpose of the factor's block below the
    // diagonal.
    let mut couplings: Vec<DMatrix<f64>> = Vec::with_capacity(above.len());
    let mut forward: Vec<DVector<f64>> = Vec::with_capacity(right.len());
    for (k, (block, right)) in diagonal.iter().zip(right).enumerate() {
        let (mut block, mut right) = (block.clone(), right.clone());
        if let Some(before) = factors.last() {
            let lower = before.l_dirty();
            let mut coupling = above[k - 1].clone();
            lower.solve_lower_triangular_mut(&mut coupling);
            block.gemm_tr(-1.0, &coupling, &coupling, 1.0);
            right.gemv_tr(-1.0, &coupling, &forward[k - 1], 1.0);
            couplings.push(coupling);
        }
        let factor = Cholesky::new(block)?;
        factor.l_dirty().solve_lower_triangular_mut(&mut right);
        forward.push(right);
        factors.push(factor);
    }
    for k in (0..factors.len()).rev() {
        if let Some(coupling) = couplings.get(k) {
            let (before, after) = forward.split_at_mut(k + 1);
            before[k].gemv(-1.0, coupling, &after[0], 1.0);
        }
        factors[k].l_dirty().tr_solve_lower_triangular_mut(&mut forward[k]);
    }
    Some(forward)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solutions_are_those_of_the_whole_matrix() {
        let number = |i: usize, j: usize, k: usize| libm::sin((3 * i + 7 * j + 11 * k + 1) as f64);
        let (size, blocks) = (4, 5);
        let diagonal: Vec<_> = (0..blocks)
            .map(|k| {
                let any = DMatrix::from_fn(size, size, |i, j| number(i, j, k));
                any.tr_mul(&any) + DMatrix::identity(size, size) * 6.0
            })
            .collect();
        let above: Vec<_> = (0..blocks - 1)
            .map(|k| DMatrix::from_fn(size, size, |i, j| number(j, i, k + 20)))
            .collect();
        let right: Vec<_> =
            (0..blocks).map(|k| DVector::from_fn(size, |i, _| number(i, 5, k))).collect();
        let solution = solve(&diagonal, &above, &right).unwrap();
        for k in 0..blocks {
            let mut product = &diagonal[k] * &solution[k];
            if k > 0 {
                product += above[k - 1].tr_mul(&solution[k - 1]);
            }
            if k + 1 < blocks {
                product += &above[k] * &solution[k + 1];
            }
            assert!((product - &right[k]).amax() < 1e-12);
        }
        let indefinite = [-&diagonal[0]];
        assert_eq!(solve(&indefinite, &[], &right[..1]), None);
    }
}
