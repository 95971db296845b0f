//! The energy near a curve, to second order, and its Newton step.

use nalgebra::DVector;

use super::by_joint;
use super::by_pose::Blocks;
use super::curve::Curve;
use super::pose_model::PoseModel;
use super::rig::Rig;

/// Addition to second derivatives per unit of the gradient.
const RIDGE: f64 = 0.3;

/// The energy near a curve, to second order, with barriers at the ends of ranges.
pub(super) struct Model {
    /// Models of the inner poses.
    poses: Vec<PoseModel>,
    /// Matrix, if it is eliminated pose by pose.
    blocks: Option<Blocks>,
    /// Largest component of the gradient that no limit's force balances.
    pub(super) gradient: f64,
    /// Largest product of a limit's gap and force, m².
    pub(super) press_m2: f64,
    /// Target value of these products: the height of the barriers.
    height_m2: f64,
    has_second_derivatives: bool,
}

/// A step of all poses.
pub(super) struct Direction {
    /// Step of each pose.
    pub(super) step: Vec<DVector<f64>>,
    /// Values that were added to the diagonal for the step.
    added: Vec<DVector<f64>>,
}

/// A curve after a step.
pub(super) struct NextCurve {
    pub(super) curve: Curve,
    /// Decrease of the curve's energy, including that of the barriers, m².
    pub(super) gain_m2: f64,
    /// Predicted decrease for the share of the step that was made, m².
    pub(super) predicted_m2: f64,
    /// Predicted decrease for the whole step, m².
    pub(super) decrement_m2: f64,
}

/// The order in which the unknowns are eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// All joints of a pose together: O(poses · columns³).
    Poses,
    /// Each joint in all poses together: O(joints · poses³).
    Joints,
}

impl Order {
    /// Returns the cheaper order: `p c³` against `(c / 3) (6 p)³`, since a body has six velocities and most joints
    /// are ball joints.
    fn cheaper(rig: &Rig, poses: usize) -> Self {
        if rig.columns * rig.columns > 72 * poses * poses { Self::Joints } else { Self::Poses }
    }
}

impl Model {
    pub(super) fn new(
        rig: &Rig,
        curve: &Curve,
        has_second_derivatives: bool,
        height_m2: f64,
    ) -> Self {
        let order = Order::cheaper(rig, curve.inner().len());
        Self::in_order(rig, curve, has_second_derivatives, height_m2, order)
    }

    pub(super) fn in_order(
        rig: &Rig,
        curve: &Curve,
        has_second_derivatives: bool,
        height_m2: f64,
        order: Order,
    ) -> Self {
        let inner = 1..curve.placed.len() - 1;
        let mut poses: Vec<_> = inner.map(|k| PoseModel::new(rig, curve, k)).collect();
        let gradient = poses.iter().map(|pose| pose.downhill.amax()).fold(0.0, f64::max);
        let limits = curve.limits.iter().flatten();
        let press_m2 = limits.map(|limit| limit.gap * limit.force).fold(0.0, f64::max);
        // Replaces the limits' forces by those of the barriers.
        for (pose, limits) in poses.iter_mut().zip(&curve.limits) {
            for limit in limits {
                pose.downhill[limit.column] += (height_m2 / limit.gap - limit.force) * limit.slope;
            }
        }
        let blocks = (order == Order::Poses)
            .then(|| Blocks::new(rig, curve.inner(), &poses, has_second_derivatives));
        Self { poses, blocks, gradient, press_m2, height_m2, has_second_derivatives }
    }

    /// Returns the curve after a step; `None` if the step cannot be computed.
    pub(super) fn step(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<NextCurve> {
        let Direction { step, added } = self.direction(rig, curve, damping)?;
        // For the step `s`, with (H + D) s = -g: -gᵀs and sᵀDs.
        let (mut slope, mut damped) = (0.0, 0.0);
        for ((pose, step), added) in self.poses.iter().zip(&step).zip(&added) {
            slope += pose.downhill.dot(step);
            damped += step.component_mul(added).dot(step);
        }
        // Predicted decrease for a share t of the step: -t gᵀs - ½ t² sᵀHs.
        let less = |t: f64| t * slope - 0.5 * t * t * (slope - damped);
        let (next, share) = curve.stepped(rig, &step, self.height_m2);
        Some(NextCurve {
            gain_m2: curve.gain_m2(&next, self.height_m2),
            predicted_m2: less(share),
            decrement_m2: less(1.0),
            curve: next,
        })
    }

    /// Computes Newton's step; `None` if the matrix is not positive definite.
    pub(super) fn direction(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<Direction> {
        let largest = self.poses.iter().map(|pose| pose.own.max()).fold(0.0, f64::max);
        let solve = |bends: bool, ridge: f64| {
            // Rotations that move almost nothing get a floor; without it their steps would be arbitrary.
            let floor = 1e-3 * largest;
            let added = |own: f64| damping * own.max(floor) + 1e-12 * largest + ridge;
            let diagonals = self.poses.iter().map(|pose| &pose.own + &pose.barrier);
            let added: Vec<_> = diagonals.map(|own| own.map(added)).collect();
            let step = match &self.blocks {
                Some(blocks) => blocks.solve(bends, &added, &self.poses),
                None => by_joint::solve(rig, curve.inner(), &self.poses, bends, &added),
            };
            Some(Direction { step: step?, added })
        };
        // Rotations of two joints that cancel each other move nothing. Second derivatives along them are as large
        // as the gradient, and of either sign. A ridge of that size keeps them positive, and vanishes near the
        // solution. If the matrix is still not positive definite, the Gauss-Newton method is used.
        let newton = self.has_second_derivatives.then(|| solve(true, RIDGE * self.gradient));
        newton.flatten().or_else(|| solve(false, 0.0))
    }
}
