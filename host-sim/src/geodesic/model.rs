//! The energy near a curve, to second order, and Newton's step in it.

use nalgebra::DVector;

use super::by_joint;
use super::by_pose::Blocks;
use super::derivatives::Pull;
use super::rig::Rig;
use super::solver::Curve;

/// What is added to second derivatives for every unit of the gradient.
const RIDGE: f64 = 0.3;

/// The energy near a curve, to second order, with what the ranges hold.
pub(super) struct Model {
    /// Of each pose between the ends.
    poses: Vec<PoseModel>,
    /// The matrix, where it is eliminated pose by pose.
    blocks: Option<Blocks>,
    /// Largest component of the gradient that is not held.
    pub(super) gradient: f64,
    has_second_derivatives: bool,
}

/// What a model knows of one pose, by column.
pub(super) struct PoseModel {
    /// Minus the gradient; 0 where held.
    pub(super) downhill: DVector<f64>,
    /// Whether it is pressed against an end of its range, and stays.
    pub(super) held: Vec<bool>,
    /// What ends of turns add to the diagonal.
    pub(super) rim: DVector<f64>,
    /// The diagonal without second derivatives, 1 where held.
    own: DVector<f64>,
    /// What the forces of the curve's bends do.
    pub(super) pull: Pull,
}

/// Where the curve goes to.
pub(super) struct Direction {
    /// The step of each pose.
    pub(super) step: Vec<DVector<f64>>,
    /// What was added to the diagonal for it.
    added: Vec<DVector<f64>>,
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
    pub(super) fn new(rig: &Rig, curve: &Curve, has_second_derivatives: bool) -> Self {
        let poses = curve.placed.len().saturating_sub(2);
        Self::in_order(rig, curve, has_second_derivatives, Order::cheaper(rig, poses))
    }

    pub(super) fn in_order(
        rig: &Rig,
        curve: &Curve,
        has_second_derivatives: bool,
        order: Order,
    ) -> Self {
        let inner = 1..curve.placed.len() - 1;
        let poses: Vec<_> = inner.map(|k| PoseModel::new(rig, curve, k)).collect();
        let gradient = poses.iter().map(|pose| pose.downhill.amax()).fold(0.0, f64::max);
        let blocks = (order == Order::Poses)
            .then(|| Blocks::new(rig, curve.inner(), &poses, has_second_derivatives));
        Self { poses, blocks, gradient, has_second_derivatives }
    }

    /// How many coordinates ranges hold.
    #[cfg(test)]
    pub(super) fn held(&self) -> usize {
        self.poses.iter().flat_map(|pose| &pose.held).filter(|held| **held).count()
    }

    /// The curve after a step, and how much less its energy should be. `None` if the step cannot be found.
    pub(super) fn step(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<(Curve, f64)> {
        let Direction { step, added } = self.direction(rig, curve, damping)?;
        // What the model says of the step: -gᵀs - ½ sᵀHs, with (H + D) s = -g.
        let mut predicted = 0.0;
        for ((pose, step), added) in self.poses.iter().zip(&step).zip(&added) {
            predicted += 0.5 * (pose.downhill.dot(step) + step.component_mul(added).dot(step));
        }
        let mut poses = curve.poses.clone();
        for (pose, step) in poses[1..].iter_mut().zip(&step) {
            *pose = rig.stepped(pose, step.as_slice());
        }
        Some((Curve::new(rig, poses), predicted))
    }

    /// Newton's step. `None` if it cannot be found.
    pub(super) fn direction(&self, rig: &Rig, curve: &Curve, damping: f64) -> Option<Direction> {
        let largest = self.poses.iter().map(|pose| pose.own.max()).fold(0.0, f64::max);
        let solve = |bends: bool, ridge: f64| {
            // Turns that move next to nothing get a floor: without one they go anywhere.
            let floor = 1e-3 * largest;
            let added = |own: f64| damping * own.max(floor) + 1e-12 * largest + ridge;
            let added: Vec<_> = self.poses.iter().map(|pose| pose.own.map(added)).collect();
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

impl PoseModel {
    fn new(rig: &Rig, curve: &Curve, k: usize) -> Self {
        let [before, at, after] = [k - 1, k, k + 1].map(|k| &curve.placed[k]);
        let force = ((&at.f - &before.f) - (&after.f - &at.f)) * 2.0;
        let pull = rig.pull(at, &force);
        let mut downhill = -&pull.along;
        let ends = rig.ends(&curve.poses[k]);
        let held: Vec<bool> = ends
            .iter()
            .zip(&downhill)
            .map(|(end, downhill)| end[usize::from(*downhill > 0.0)])
            .collect();
        // Who goes along the end of a turn's range is brought back onto it, uphill.
        let mut rim = DVector::zeros(rig.columns);
        for (column, bend) in rig.spheres(&curve.poses[k]) {
            if held[column] {
                for across in [column + 1, column + 2] {
                    rim[across] += downhill[column] * bend;
                }
            }
        }
        let mut own = rig.squares(at) * 4.0 + &rim;
        for (index, _) in held.iter().enumerate().filter(|(_, held)| **held) {
            (downhill[index], own[index]) = (0.0, 1.0);
        }
        Self { downhill, held, rim, own, pull }
    }
}
