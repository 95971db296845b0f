//! Newton's step, eliminated joint by joint: each joint is eliminated in all poses at once, from the leaves to the
//! root, as the articulated-body algorithm does within a single pose. The rest of a curve feels a joint as a
//! quadratic form in the velocities of its parent in all poses, since a position depends only on its parent's
//! velocity and its own joint.

use glam::DVec3;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

use super::joint::Axis;
use super::pose_model::PoseModel;
use super::rig::{Rig, RigPose};

/// The energy that a body and its descendants contribute: `½ Vᵀ matrix V - pullᵀ V`. V contains the velocities of the
/// body in all poses: for each pose, the angular velocity and the velocity of the body's position.
#[derive(Clone)]
struct Carried {
    matrix: DMatrix<f64>,
    pull: DVector<f64>,
}

/// An eliminated joint: `L Lᵀ` is its own matrix, and its step is `L⁻ᵀ (right - coupling V)`. V contains the velocities
/// of its parent in all poses.
struct Eliminated {
    factor: Cholesky<f64, Dyn>,
    coupling: DMatrix<f64>,
    right: DVector<f64>,
}

/// Returns the step of each pose, with `added` on the diagonal; `None` if the matrix is not positive definite.
/// O(joints · poses³).
pub(super) fn solve(
    rig: &Rig,
    placed: &[RigPose],
    poses: &[PoseModel],
    bends: bool,
    added: &[DVector<f64>],
) -> Option<Vec<DVector<f64>>> {
    let (count, size) = (rig.joints.len(), 6 * placed.len());
    let nothing = Carried { matrix: DMatrix::zeros(size, size), pull: DVector::zeros(size) };
    let mut carried: Vec<Option<Carried>> = vec![None; count];
    let mut eliminated: Vec<Option<Eliminated>> = (0..count).map(|_| None).collect();
    let first = first_columns(rig);
    let joint = |index: usize| Joint { rig, placed, poses, index, first: first[index] };
    for index in (0..count).rev() {
        let Some(parent) = rig.joints[index].parent else { continue };
        let joint = joint(index);
        let mut own = carried[index].take().unwrap_or_else(|| nothing.clone());
        add_positions(&mut own.matrix, rig.joints[index].weight);
        let through = if rig.joints[index].columns() == 0 {
            joint.on_parent(own)
        } else {
            let (rest, own) = joint.eliminate(own, bends, added)?;
            eliminated[index] = Some(own);
            rest
        };
        match &mut carried[parent] {
            Some(sum) => {
                sum.matrix += through.matrix;
                sum.pull += through.pull;
            }
            none => *none = Some(through),
        }
    }
    let mut steps = vec![DVector::zeros(rig.columns); placed.len()];
    let mut velocities: Vec<DVector<f64>> = vec![DVector::zeros(size); count];
    for index in 0..count {
        let Some(parent) = rig.joints[index].parent else { continue };
        let joint = joint(index);
        let mut velocity = joint.carried(&velocities[parent]);
        if let Some(own) = &eliminated[index] {
            let mut step = own.right.clone();
            step.gemv(-1.0, &own.coupling, &velocities[parent], 1.0);
            own.factor.l_dirty().tr_solve_lower_triangular_mut(&mut step);
            for (row, k, column) in joint.rows() {
                let Axis { angular, linear } = joint.axis(k, column);
                add(&mut velocity, 6 * k, angular * step[row]);
                add(&mut velocity, 6 * k + 3, linear * step[row]);
                steps[k][column] = step[row];
            }
        }
        velocities[index] = velocity;
    }
    Some(steps)
}

/// Returns the first column of each joint.
fn first_columns(rig: &Rig) -> Vec<usize> {
    let mut next = 0;
    let first = rig.joints.iter().map(|joint| {
        let own = next;
        next += joint.columns();
        own
    });
    first.collect()
}

/// Adds the squared steps of a position from pose to pose: 4 on the diagonal of its velocities, -2 beside it,
/// times the weight.
fn add_positions(matrix: &mut DMatrix<f64>, weight: f64) {
    for row in (0..matrix.nrows()).filter(|row| row % 6 >= 3) {
        matrix[(row, row)] += 4.0 * weight;
        if row >= 6 {
            matrix[(row, row - 6)] -= 2.0 * weight;
            matrix[(row - 6, row)] -= 2.0 * weight;
        }
    }
}

/// A joint in all poses.
#[derive(Clone, Copy)]
struct Joint<'a> {
    rig: &'a Rig,
    placed: &'a [RigPose],
    poses: &'a [PoseModel],
    index: usize,
    first: usize,
}

impl Joint<'_> {
    /// Returns row, pose and column of each unknown.
    fn rows(self) -> impl Iterator<Item = (usize, usize, usize)> {
        let own = self.rig.joints[self.index].columns();
        (0..self.placed.len() * own).map(move |row| (row, row / own, self.first + row % own))
    }

    /// Returns the motion of the body per unit of a coordinate.
    fn axis(self, k: usize, column: usize) -> Axis {
        self.placed[k].axes[column].1
    }

    fn arm_m(self, k: usize) -> DVec3 {
        let parent = self.rig.joints[self.index].parent.unwrap_or(self.index);
        self.placed[k].positions_m[self.index] - self.placed[k].positions_m[parent]
    }

    /// Returns the velocity that results from the parent's velocity.
    fn carried(self, parent: &DVector<f64>) -> DVector<f64> {
        let mut velocity = parent.clone();
        for k in 0..self.placed.len() {
            add(&mut velocity, 6 * k + 3, at(parent, 6 * k).cross(self.arm_m(k)));
        }
        velocity
    }

    /// Converts a pull on the body to a pull on its parent.
    fn to_parent(self, pull: &mut [f64]) {
        for k in 0..self.placed.len() {
            let torque = self.arm_m(k).cross(DVec3::from_slice(&pull[6 * k + 3..]));
            for (pull, torque) in pull[6 * k..].iter_mut().zip(torque.to_array()) {
                *pull += torque;
            }
        }
    }

    /// Converts the energy to the parent's velocities, with the joint at rest.
    fn on_parent(self, own: Carried) -> Carried {
        let Carried { mut matrix, mut pull } = own;
        self.to_parent(pull.as_mut_slice());
        // First the columns, then, by symmetry, the rows.
        for _ in 0..2 {
            for mut column in matrix.column_iter_mut() {
                self.to_parent(column.as_mut_slice());
            }
            matrix.transpose_mut();
        }
        Carried { matrix, pull }
    }

    /// Minimizes the energy over the joint's own step. Returns the minimum as a function of the parent's velocities,
    /// and the data from which that step follows. `None` if the matrix is not positive definite.
    fn eliminate(
        self,
        body: Carried,
        bends: bool,
        added: &[DVector<f64>],
    ) -> Option<(Carried, Eliminated)> {
        let unknowns: Vec<_> = self.rows().collect();
        // The body's matrix times the axes.
        let mut moved = DMatrix::zeros(body.matrix.nrows(), unknowns.len());
        for (row, k, column) in &unknowns {
            let Axis { angular, linear } = self.axis(*k, *column);
            for (offset, part) in
                angular.to_array().into_iter().chain(linear.to_array()).enumerate()
            {
                if part != 0.0 {
                    moved.column_mut(*row).axpy(part, &body.matrix.column(6 * k + offset), 1.0);
                }
            }
        }
        let own = |of: &[f64], k: usize, column: usize| {
            let Axis { angular, linear } = self.axis(k, column);
            angular.dot(DVec3::from_slice(&of[6 * k..]))
                + linear.dot(DVec3::from_slice(&of[6 * k + 3..]))
        };
        let mut matrix = DMatrix::zeros(unknowns.len(), unknowns.len());
        let mut right = DVector::zeros(unknowns.len());
        for (row, k, column) in &unknowns {
            let pose = &self.poses[*k];
            right[*row] = own(body.pull.as_slice(), *k, *column) + pose.downhill[*column];
            for (other, moved) in moved.column_iter().enumerate() {
                matrix[(*row, other)] = own(moved.as_slice(), *k, *column);
            }
            matrix[(*row, *row)] += pose.barrier[*column] + added[*k][*column];
        }
        for mut column in moved.column_iter_mut() {
            self.to_parent(column.as_mut_slice());
        }
        if bends {
            for (row, k, column) in &unknowns {
                let (pose, placed) = (&self.poses[*k], &self.placed[*k]);
                for outer in self.first..=*column {
                    let value = self.rig.bend_along(placed, &pose.pull, outer, *column);
                    let other = row - (column - outer);
                    matrix[(other, *row)] += value;
                    if other != *row {
                        matrix[(*row, other)] += value;
                    }
                }
                add_to(moved.column_mut(*row).as_mut_slice(), 6 * k, pose.pull.gathered[*column]);
            }
        }
        let factor = Cholesky::new(matrix)?;
        factor.l_dirty().solve_lower_triangular_mut(&mut right);
        let mut coupling = moved.transpose();
        factor.l_dirty().solve_lower_triangular_mut(&mut coupling);
        let mut rest = self.on_parent(body);
        rest.matrix.gemm_tr(-1.0, &coupling, &coupling, 1.0);
        rest.pull.gemv_tr(-1.0, &coupling, &right, 1.0);
        Some((rest, Eliminated { factor, coupling, right }))
    }
}

fn at(of: &DVector<f64>, start: usize) -> DVec3 {
    DVec3::from_slice(&of.as_slice()[start..])
}

fn add(to: &mut DVector<f64>, start: usize, what: DVec3) {
    add_to(to.as_mut_slice(), start, what);
}

fn add_to(to: &mut [f64], start: usize, what: DVec3) {
    for (to, what) in to[start..].iter_mut().zip(what.to_array()) {
        *to += what;
    }
}
