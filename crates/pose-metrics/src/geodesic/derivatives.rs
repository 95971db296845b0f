//! First and second derivatives of the positions of a rig's joints with respect to the rig's pose.

use glam::{DMat3, DVec3};
use nalgebra::{DMatrix, DVector};

use super::joint::Model;
use super::rig::{Rig, RigPose};

/// The effect of a force on every joint of a rig, by column.
#[derive(Debug, Clone)]
pub(super) struct Pull {
    /// Product of Jᵀ and the force.
    pub(super) along: DVector<f64>,
    /// Sum, over all joints that an axis moves, of the cross product of two vectors: the velocity that the axis gives
    /// to the joint, and the force on the joint. Multiplied by the angular velocity of an outer axis, it gives the
    /// change of the force along the column. For a ball joint that turns in the world ([`Rig::stepped`]), the sum
    /// contains the mean over both orders of the axes.
    pub(super) gathered: Vec<DVec3>,
}

impl Rig {
    /// Returns the weighted Jacobian `W½ J` at a pose: a column for each axis of each moving joint.
    pub(super) fn jacobian(&self, at: &RigPose) -> DMatrix<f64> {
        let mut jacobian = DMatrix::zeros(3 * self.joints.len(), self.columns);
        for (column, (moving, axis)) in at.axes.iter().enumerate() {
            for (index, joint) in self.joints.iter().enumerate().skip(*moving) {
                if !self.carries(*moving, index) {
                    continue;
                }
                let arm = at.positions_m[index] - at.positions_m[*moving];
                let moved = (axis.angular.cross(arm) + axis.linear) * libm::sqrt(joint.weight);
                jacobian
                    .fixed_view_mut::<3, 1>(3 * index, column)
                    .copy_from_slice(&moved.to_array());
            }
        }
        jacobian
    }

    /// Returns the squared lengths of the Jacobian's columns. O(joints).
    pub(super) fn squares(&self, at: &RigPose) -> DVector<f64> {
        // Sums over each joint's subtree: Σ w, Σ w r and Σ w r rᵀ, with r from the joint.
        let count = self.joints.len();
        let mut weight = vec![0.0; count];
        let mut first = vec![DVec3::ZERO; count];
        let mut second = vec![DMat3::ZERO; count];
        for index in (0..count).rev() {
            weight[index] += self.joints[index].weight;
            if let Some(parent) = self.joints[index].parent {
                let arm = at.positions_m[index] - at.positions_m[parent];
                let (w, sum) = (weight[index], first[index]);
                weight[parent] += w;
                first[parent] += sum + arm * w;
                let moved = outer(sum, arm) + outer(arm, sum) + outer(arm, arm * w);
                let carried = second[index];
                second[parent] += carried + moved;
            }
        }
        let squares = at.axes.iter().map(|(joint, axis)| {
            let (turn, slide) = (axis.angular, axis.linear);
            let moment = second[*joint];
            let turned = turn.length_squared() * trace(moment) - turn.dot(moment * turn);
            turned
                + 2.0 * slide.dot(turn.cross(first[*joint]))
                + weight[*joint] * slide.length_squared()
        });
        DVector::from_iterator(self.columns, squares)
    }

    /// Computes the effect of a force on F. O(joints).
    pub(super) fn pull(&self, at: &RigPose, force: &DVector<f64>) -> Pull {
        let count = self.joints.len();
        // Sums over each joint's subtree: the forces, the moment matrix Σ r fᵀ about the joint, and the part of it
        // for second derivatives.
        let mut sum = vec![DVec3::ZERO; count];
        let mut moment = vec![DMat3::ZERO; count];
        let mut bent = vec![DMat3::ZERO; count];
        for index in (0..count).rev() {
            let joint = &self.joints[index];
            let own = DVec3::from_slice(&force.as_slice()[3 * index..]) * libm::sqrt(joint.weight);
            sum[index] += own;
            if joint.turns_in_world() {
                bent[index] = (bent[index] + bent[index].transpose()) * 0.5;
            }
            if let Some(parent) = joint.parent {
                let arm = at.positions_m[index] - at.positions_m[parent];
                let (force, carried, of_bends) = (sum[index], moment[index], bent[index]);
                sum[parent] += force;
                moment[parent] += carried + outer(arm, force);
                bent[parent] += of_bends + outer(arm, force);
            }
        }
        let along = at.axes.iter().map(|(joint, axis)| {
            let moment = moment[*joint];
            let [x, y, z] = [moment.x_axis, moment.y_axis, moment.z_axis];
            // The torque is Σ r × f.
            let torque = DVec3::new(z.y - y.z, x.z - z.x, y.x - x.y);
            axis.angular.dot(torque) + axis.linear.dot(sum[*joint])
        });
        let gathered = at.axes.iter().map(|(joint, axis)| {
            let (matrix, turn) = (bent[*joint], axis.angular);
            matrix * turn - turn * trace(matrix) + axis.linear.cross(sum[*joint])
        });
        Pull { along: DVector::from_iterator(self.columns, along), gathered: gathered.collect() }
    }

    /// Returns the sum over all joints of the force times the second derivative of their (weighted) positions: the
    /// curvature, along the force, of the surface that F describes.
    pub(super) fn bend(&self, at: &RigPose, pull: &Pull) -> DMatrix<f64> {
        let mut bend = DMatrix::zeros(self.columns, self.columns);
        for (inner, (of_inner, _)) in at.axes.iter().enumerate() {
            for (outer, (of_outer, _)) in at.axes.iter().enumerate().take(inner + 1) {
                if self.carries(*of_outer, *of_inner) {
                    let value = self.bend_along(at, pull, outer, inner);
                    bend[(outer, inner)] = value;
                    bend[(inner, outer)] = value;
                }
            }
        }
        bend
    }

    /// Returns [`Rig::bend`] along two columns. The outer column's joint is an ancestor of the inner column's joint, or
    /// the same joint.
    ///
    /// An outer axis rotates the velocity `u` that an inner axis gives: `∂²p = a × u`. For two axes of one ball
    /// joint it is the mean over both orders.
    pub(super) fn bend_along(&self, at: &RigPose, pull: &Pull, outer: usize, inner: usize) -> f64 {
        let ((of_outer, a), (of_inner, b)) = (&at.axes[outer], &at.axes[inner]);
        let (a, b) = (a.angular, b.angular);
        let is_ball = of_outer == of_inner
            && matches!(self.joints[*of_outer].model, Model::Spherical | Model::Free);
        if !is_ball {
            a.dot(pull.gathered[inner])
        } else if a == DVec3::ZERO || b == DVec3::ZERO {
            // Zero for a slide in the frame that the rotation does not affect.
            0.0
        } else {
            0.5 * (a.dot(pull.gathered[inner]) + b.dot(pull.gathered[outer]))
        }
    }
}

/// Returns `a bᵀ`.
fn outer(a: DVec3, b: DVec3) -> DMat3 {
    DMat3::from_cols(a * b.x, a * b.y, a * b.z)
}

fn trace(matrix: DMat3) -> f64 {
    matrix.x_axis.x + matrix.y_axis.y + matrix.z_axis.z
}
