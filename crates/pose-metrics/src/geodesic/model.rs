//! The energy near a curve, to second order, and Newton's step in it.

use nalgebra::DVector;

use super::by_joint;
use super::by_pose::Blocks;
use super::curve::Curve;
use super::pose_model::PoseModel;
use super::rig::Rig;

/// What is added to second derivatives for every unit of the gradient.
const RIDGE: f64 = 0.3;

/// The energy near a curve, to second order, with barriers before the ends of ranges.
pub(super) struct Model {
    /// Of each pose between the ends.
    poses: Vec<PoseModel>,
    /// The matrix, where it is eliminated pose by pose.
    blocks: Option<Blocks>,
    /// Largest component of the gradient that no limit's force takes.
    pub(super) gradient: f64,
    /// Largest product of a limit's gap and force, m².
    pub(super) press_m2: f64,
    /// What these products are to be: the barriers' height.
    height_m2: f64,
    has_second_derivatives: bool,
}

/// Where the curve goes to.
pub(super) struct Direction {
    /// The step of each pose.
    pub(super) step: Vec<DVector<f64>>,
    /// What was added to the diagonal for it.
    added: Vec<DVector<f64>>,
}

/// A curve after a step.
pub(super) struct NextCurve {
    pub(super) curve: Curve,
    /// How much less its energy is, with that of barriers, m².
    pub(super) gain_m2: f64,
    /// How much less it should be, m².
    pub(super) predicted_m2: f64,
    /// How much less it should be after the whole step, where a limit kept the curve from taking it, m².
    pub(super) decrement_m2: f64,
}

/// In which order the unknowns are eliminated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    /// All joints of a pose together: O(poses · columns³).
    Poses,
    /// A joint in all poses together: O(joints · poses³).
    Joints,
}

impl Order {
    /// The cheaper one: `p c³` against `(c / 3) (6 p)³`, since a body has six velocities and most joints are balls.
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
        // From the forces that limits have to those of barriers.
        for (pose, limits) in poses.iter_mut().zip(&curve.limits) {
            for limit in limits {
                pose.downhill[limit.column] += (height_m2 / limit.gap - limit.force) * limit.slope;
            }
        }
        let blocks = (order == Order::Poses)
            .then(|| Blocks::new(rig, curve.inner(), &poses, has_second_derivatives));
        Self { poses, blocks, gradient, press_m2, height_m2, has_second_derivatives }
    }

    /// The curve after a step. `None` if the step cannot be found.
    pub(super) fn step(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<NextCurve> {
        let Direction { step, added } = self.direction(rig, curve, damping)?;
        // Of the step `s`, with (H + D) s = -g: -gᵀs and sᵀDs.
        let (mut slope, mut damped) = (0.0, 0.0);
        for ((pose, step), added) in self.poses.iter().zip(&step).zip(&added) {
            slope += pose.downhill.dot(step);
            damped += step.component_mul(added).dot(step);
        }
        // What the model says of a share t of it: -t gᵀs - ½ t² sᵀHs.
        let less = |t: f64| t * slope - 0.5 * t * t * (slope - damped);
        let (next, share) = curve.stepped(rig, &step, self.height_m2);
        Some(NextCurve {
            gain_m2: curve.gain_m2(&next, self.height_m2),
            predicted_m2: less(share),
            decrement_m2: less(1.0),
            curve: next,
        })
    }

    /// Newton's step. `None` if it cannot be found.
    pub(super) fn direction(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<Direction> {
        let largest = self.poses.iter().map(|pose| pose.own.max()).fold(0.0, f64::max);
        let solve = |bends: bool, ridge: f64| {
            // Turns that move next to nothing get a floor: without one they go anywhere.
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
        // Turns of two joints that undo each other move nothing; second derivatives along them are as large as the
        // gradient, of either sign. A ridge of that size keeps them positive, and goes as the end is near. Where even
        // so it is not convex, the method of Gauss and Newton is.
        let newton = self.has_second_derivatives.then(|| solve(true, RIDGE * self.gradient));
        newton.flatten().or_else(|| solve(false, 0.0))
    }
}
