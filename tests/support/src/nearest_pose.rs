//! The pose of a figure that is nearest to a desired pose, by dense least squares in f64.
//!
//! All joints' coordinates are one vector, all bodies' weighted residuals another. The derivative is computed from
//! differences of whole poses. The core's sweeps, inertias and Jacobians are not used.

use glam::{DMat3, DQuat, DVec3};
use nalgebra::{DMatrix, DVector};
use sinew_core::projection::{BodyWeight, JointRange};
use sinew_core::{JointKind, Transform, Tree};

use crate::reference::{Pose, turn};

/// Step of the central differences: with residuals of the order of 1, truncation is 1e-10 and rounding 1e-11.
const STEP: f64 = 1e-5;

/// Largest distance, rad or m, of a coordinate from the end of its range at which it counts as being at this end. f32
/// resolves a turn to 1e-7, and a product of several turns more coarsely.
const AT_END: f64 = 2e-6;

/// A figure, the desired poses of its bodies, and their weights.
#[derive(Debug, Clone)]
pub struct Problem {
    joints: Vec<Joint>,
    /// Desired poses in the world.
    desired: Vec<Pose>,
    weights: Vec<BodyWeight>,
}

#[derive(Debug, Clone)]
struct Joint {
    parent: Option<usize>,
    placement: Pose,
    kind: JointKind,
    range: JointRange,
    /// Pose of a joint that cannot move.
    held: Option<Pose>,
}

/// Coordinates of one joint, in its joint frame.
#[derive(Debug, Clone, Copy)]
enum Coordinates {
    Held(Pose),
    One(f64),
    Two([f64; 2]),
    Turn(DQuat),
    Free(Pose),
}

/// Coordinates of all joints.
#[derive(Debug, Clone)]
pub struct Solution(Vec<Coordinates>);

/// Converts a pose to f64, with a unit rotation.
pub fn pose(pose: &Transform) -> Pose {
    Pose {
        rotation: pose.rotation.as_dquat().normalize(),
        position_m: pose.translation_m.as_dvec3(),
    }
}

/// Returns the world poses of joints that are given in their parents' frames.
pub fn world(tree_parents: impl Iterator<Item = Option<usize>>, joints: &[Pose]) -> Vec<Pose> {
    let mut poses: Vec<Pose> = Vec::new();
    for (parent, joint) in tree_parents.zip(joints) {
        let parent = parent.map_or(Pose::WORLD, |parent| poses[parent]);
        poses.push(parent.times(joint));
    }
    poses
}

impl Problem {
    /// Creates a problem. `desired` contains the pose of each joint in its parent's frame, as for the core.
    pub fn new<const N: usize>(
        tree: &Tree<N>,
        weights: &[BodyWeight],
        ranges: &[JointRange],
        root_held: bool,
        desired: &[Transform],
    ) -> Self {
        let joint_poses: Vec<Pose> = desired.iter().map(pose).collect();
        let joint = |(body, range): (&sinew_core::Body, &JointRange)| {
            let fixed = matches!(body.joint, JointKind::Fixed);
            let held = match body.parent {
                None if fixed || root_held => Some(joint_poses[0]),
                Some(_) if fixed => Some(pose(&body.placement)),
                _ => None,
            };
            let placement = pose(&body.placement);
            Joint { parent: body.parent, placement, kind: body.joint, range: *range, held }
        };
        let parents = tree.bodies().iter().map(|body| body.parent);
        Self {
            joints: tree.bodies().iter().zip(ranges).map(joint).collect(),
            desired: world(parents, &joint_poses),
            weights: weights.to_vec(),
        }
    }

    /// Returns the coordinates within the ranges that are nearest to the given poses. A pose is given for each
    /// joint, in its parent's frame.
    pub fn nearest(&self, poses: &[Transform]) -> Solution {
        let of_joint = |(joint, given): (&Joint, &Transform)| {
            joint.within_range(joint.coordinates(&pose(given)))
        };
        Solution(self.joints.iter().zip(poses).map(of_joint).collect())
    }

    /// Returns the distance of the given poses from poses that the joints can reach within their ranges, in rad or m.
    pub fn excess(&self, poses: &[Transform]) -> f64 {
        let nearest = self.nearest(poses);
        let joints = self.joints.iter().zip(&nearest.0).zip(poses);
        joints.fold(0.0, |most, ((joint, coordinates), given)| {
            most.max(distance(&joint.pose(coordinates), &pose(given)))
        })
    }

    /// Returns the poses of the joints in their parents' frames.
    pub fn joint_poses(&self, solution: &Solution) -> Vec<Pose> {
        self.joints.iter().zip(&solution.0).map(|(joint, at)| joint.pose(at)).collect()
    }

    /// Returns the cost that the projection minimizes, for the world poses of a solution: `Σ wᵢ |pᵢ - p_d,i|² + ρᵢ²
    /// |Log(Rᵢ R_d,iᵀ)|²`, m².
    pub fn cost(&self, solution: &Solution) -> f64 {
        self.residuals(solution).norm_squared()
    }

    /// Returns the solution after one Gauss-Newton step, computed by QR without the ranges. In the given solution, the
    /// bodies must have their desired orientations. The curvature of arms that are pulled outwards is added as rows
    /// that resist turns.
    ///
    /// Also returns the largest component of the step, rad or m.
    pub fn step(&self, solution: &Solution) -> (Solution, f64) {
        let jacobian = self.jacobian(solution);
        let rows = jacobian.nrows();
        let stiffening = self.stiffening(solution);
        let mut free = jacobian.clone().resize_vertically(rows + 3 * stiffening.len(), 0.0);
        for (k, (parent, stiffening)) in stiffening.iter().enumerate() {
            let scale = stiffening.sqrt() / f64::from(self.weights[*parent].rotation_m);
            let turn = jacobian.rows(6 * parent + 3, 3) * scale;
            free.rows_mut(rows + 3 * k, 3).copy_from(&turn);
        }
        let residuals = self.residuals(solution).resize_vertically(free.nrows(), 0.0);
        let (q, r) = free.qr().unpack();
        let step = -r
            .solve_upper_triangular(&(q.transpose() * residuals))
            .expect("every turn has a weight");
        let largest = step.amax();
        (self.moved(solution, &step), largest)
    }

    /// Returns, for each body, its parent and how strongly the arm between them resists a turn of the parent: the
    /// outward component of the pull on the body and on all bodies beyond it.
    fn stiffening(&self, solution: &Solution) -> Vec<(usize, f64)> {
        let parents = self.joints.iter().map(|joint| joint.parent);
        let poses = world(parents, &self.joint_poses(solution));
        let bodies = poses.iter().zip(&self.desired).zip(&self.weights);
        let mut pulls: Vec<DVec3> = bodies
            .map(|((pose, desired), weight)| {
                (desired.position_m - pose.position_m) * f64::from(weight.position)
            })
            .collect();
        let mut stiffening = Vec::new();
        for (body, joint) in self.joints.iter().enumerate().rev() {
            if let Some(parent) = joint.parent {
                let arm = poses[body].position_m - poses[parent].position_m;
                stiffening.push((parent, pulls[body].dot(arm).max(0.0)));
                let pull = pulls[body];
                pulls[parent] += pull;
            }
        }
        stiffening
    }

    /// Returns the deviation of a solution from the Karush-Kuhn-Tucker conditions: the largest Gauss-Newton step (rad
    /// or m) among the coordinates that are not pressed against the ends of their ranges.
    pub fn off_the_best(&self, solution: &Solution) -> f64 {
        let jacobian = self.jacobian(solution);
        let gradient = jacobian.transpose() * self.residuals(solution);
        self.damped_step(solution, &jacobian, &gradient, 0.0).amax()
    }

    /// Minimizes the cost by Levenberg-Marquardt steps over the free coordinates, starting at a solution.
    pub fn solve(&self, start: &Solution) -> Solution {
        let mut solution = start.clone();
        let mut cost = self.cost(&solution);
        let mut damping = 1e-6;
        for _ in 0..300 {
            let jacobian = self.jacobian(&solution);
            let gradient = jacobian.transpose() * self.residuals(&solution);
            let step = self.damped_step(&solution, &jacobian, &gradient, damping);
            let next = self.moved(&solution, &step);
            let next_cost = self.cost(&next);
            if next_cost < cost {
                (solution, cost) = (next, next_cost);
                damping = f64::max(damping * 0.1, 1e-12);
            } else if damping > 1e6 {
                break;
            } else {
                damping *= 10.0;
            }
            if step.is_empty() || step.amax() < 1e-9 {
                break;
            }
        }
        solution
    }

    fn residuals(&self, solution: &Solution) -> DVector<f64> {
        let parents = self.joints.iter().map(|joint| joint.parent);
        let poses = world(parents, &self.joint_poses(solution));
        let bodies = poses.iter().zip(&self.desired).zip(&self.weights);
        let residuals = bodies.flat_map(|((pose, desired), weight)| {
            let way = pose.position_m - desired.position_m;
            let turn = turn(desired.rotation, pose.rotation);
            let (way, turn) =
                (way * f64::from(weight.position).sqrt(), turn * f64::from(weight.rotation_m));
            [way.x, way.y, way.z, turn.x, turn.y, turn.z]
        });
        DVector::from_iterator(6 * self.joints.len(), residuals)
    }

    fn jacobian(&self, solution: &Solution) -> DMatrix<f64> {
        let count = solution.0.iter().map(Coordinates::count).sum();
        let columns: Vec<_> = (0..count)
            .map(|column| {
                let at = |step: f64| {
                    let mut steps = DVector::zeros(count);
                    steps[column] = step;
                    self.residuals(&self.moved_freely(solution, &steps))
                };
                (at(STEP) - at(-STEP)) / (2.0 * STEP)
            })
            .collect();
        if columns.is_empty() {
            return DMatrix::zeros(6 * self.joints.len(), 0);
        }
        DMatrix::from_columns(&columns)
    }

    /// Returns a damped step by the normal equations. The next step corrects its rounding errors. The step is
    /// exactly zero if the gradient is zero.
    fn damped_step(
        &self,
        solution: &Solution,
        jacobian: &DMatrix<f64>,
        gradient: &DVector<f64>,
        damping: f64,
    ) -> DVector<f64> {
        let mut normal = jacobian.transpose() * jacobian;
        let mut wanted = -gradient;
        for k in 0..wanted.len() {
            normal[(k, k)] *= 1.0 + damping;
        }
        for pressed in self.pressed(solution, gradient) {
            normal.row_mut(pressed).fill(0.0);
            normal.column_mut(pressed).fill(0.0);
            normal[(pressed, pressed)] = 1.0;
            wanted[pressed] = 0.0;
        }
        normal.cholesky().expect("every turn has a weight").solve(&wanted)
    }

    /// Returns the columns of the coordinates that are at an end of their range, if the cost would fall beyond this
    /// end.
    fn pressed(&self, solution: &Solution, gradient: &DVector<f64>) -> Vec<usize> {
        let mut pressed = Vec::new();
        let mut column = 0;
        for (joint, at) in self.joints.iter().zip(&solution.0) {
            let ends = joint.at_ends(at);
            for (k, [least, most]) in ends.into_iter().enumerate() {
                let falls_up = column + k < gradient.len() && gradient[column + k] < 0.0;
                if (least && !falls_up) || (most && falls_up) {
                    pressed.push(column + k);
                }
            }
            column += at.count();
        }
        pressed
    }

    fn moved_freely(&self, solution: &Solution, steps: &DVector<f64>) -> Solution {
        let mut rest = steps.as_slice();
        let joints = self.joints.iter().zip(&solution.0);
        let moved = joints.map(|(joint, at)| {
            let (steps, after) = rest.split_at(at.count());
            rest = after;
            joint.moved(at, steps)
        });
        Solution(moved.collect())
    }

    fn moved(&self, solution: &Solution, steps: &DVector<f64>) -> Solution {
        let moved = self.moved_freely(solution, steps);
        let joints = self.joints.iter().zip(moved.0);
        Solution(joints.map(|(joint, at)| joint.within_range(at)).collect())
    }
}

impl Joint {
    fn coordinates(&self, given: &Pose) -> Coordinates {
        if let Some(held) = self.held {
            return Coordinates::Held(held);
        }
        let back = self.placement.rotation.inverse();
        let rotation = (back * given.rotation).normalize();
        let position_m = back * (given.position_m - self.placement.position_m);
        // The turn about an axis that is nearest to a rotation.
        let about = |axis: DVec3, rotation: DQuat| {
            let angle = 2.0 * rotation.xyz().dot(axis).atan2(rotation.w);
            (angle + std::f64::consts::PI).rem_euclid(std::f64::consts::TAU) - std::f64::consts::PI
        };
        match self.kind {
            JointKind::Revolute { axis } => {
                Coordinates::One(about(axis.as_dvec3().normalize(), rotation))
            }
            JointKind::Prismatic { axis } => {
                Coordinates::One(axis.as_dvec3().normalize().dot(position_m))
            }
            JointKind::Universal { first, second } => {
                let (first, second) = (first.as_dvec3().normalize(), second.as_dvec3().normalize());
                let turned = rotation * second;
                let angle = first.cross(second).dot(turned).atan2(second.dot(turned));
                let rest = DQuat::from_axis_angle(first, -angle) * rotation;
                Coordinates::Two([angle, about(second, rest)])
            }
            JointKind::Spherical => Coordinates::Turn(rotation),
            JointKind::Free => Coordinates::Free(*given),
            JointKind::Fixed => Coordinates::Held(self.placement),
        }
    }

    fn pose(&self, at: &Coordinates) -> Pose {
        let turned = |rotation| Pose { rotation, position_m: DVec3::ZERO };
        let about = |axis: sinew_core::glam::Vec3, angle| {
            DQuat::from_axis_angle(axis.as_dvec3().normalize(), angle)
        };
        let in_joint = match (*at, self.kind) {
            (Coordinates::Held(pose) | Coordinates::Free(pose), _) => return pose,
            (Coordinates::One(way), JointKind::Prismatic { axis }) => {
                Pose { position_m: axis.as_dvec3().normalize() * way, ..Pose::WORLD }
            }
            (Coordinates::One(angle), JointKind::Revolute { axis }) => turned(about(axis, angle)),
            (Coordinates::Two([a, b]), JointKind::Universal { first, second }) => {
                turned(about(first, a) * about(second, b))
            }
            (Coordinates::Turn(rotation), _) => turned(rotation),
            other => unreachable!("coordinates of another kind: {other:?}"),
        };
        self.placement.times(&in_joint)
    }

    fn moved(&self, at: &Coordinates, steps: &[f64]) -> Coordinates {
        match (*at, steps) {
            (Coordinates::Held(pose), []) => Coordinates::Held(pose),
            (Coordinates::One(x), [step]) => Coordinates::One(x + step),
            (Coordinates::Two([x, y]), [a, b]) => Coordinates::Two([x + a, y + b]),
            (Coordinates::Turn(rotation), &[a, b, c]) => {
                let turn = self.basis(rotation) * DVec3::new(a, b, c);
                Coordinates::Turn((rotation * DQuat::from_scaled_axis(turn)).normalize())
            }
            (Coordinates::Free(pose), &[a, b, c, x, y, z]) => Coordinates::Free(Pose {
                rotation: (pose.rotation * DQuat::from_scaled_axis(DVec3::new(a, b, c)))
                    .normalize(),
                position_m: pose.position_m + DVec3::new(x, y, z),
            }),
            other => unreachable!("steps of another kind: {other:?}"),
        }
    }

    /// Returns the axes of a spherical joint's step. On the border of its range, the first axis points outwards.
    fn basis(&self, rotation: DQuat) -> DMat3 {
        if !self.on_border(rotation) {
            return DMat3::IDENTITY;
        }
        let out = turn(DQuat::IDENTITY, rotation).normalize();
        let (a, b) = out.any_orthonormal_pair();
        DMat3::from_cols(out, a, b)
    }

    fn on_border(&self, rotation: DQuat) -> bool {
        let JointRange::Turn(most) = self.range else { return false };
        turn(DQuat::IDENTITY, rotation).length() > f64::from(most) - AT_END
    }

    /// Returns whether each column is at the lower and at the upper end of its range.
    fn at_ends(&self, at: &Coordinates) -> Vec<[bool; 2]> {
        let along = |x: f64, [least, most]: [f32; 2]| {
            [x < f64::from(least) + AT_END, x > f64::from(most) - AT_END]
        };
        match (*at, self.range) {
            (Coordinates::One(x), JointRange::Axis(ends)) => vec![along(x, ends)],
            (Coordinates::Two([x, y]), JointRange::Axes([a, b])) => vec![along(x, a), along(y, b)],
            (Coordinates::Turn(rotation), JointRange::Turn(_)) => {
                vec![[false, self.on_border(rotation)]]
            }
            _ => Vec::new(),
        }
    }

    fn within_range(&self, at: Coordinates) -> Coordinates {
        let along = |x: f64, [least, most]: [f32; 2]| x.clamp(least.into(), most.into());
        match (at, self.range) {
            (Coordinates::One(x), JointRange::Axis(ends)) => Coordinates::One(along(x, ends)),
            (Coordinates::Two([x, y]), JointRange::Axes([a, b])) => {
                Coordinates::Two([along(x, a), along(y, b)])
            }
            (Coordinates::Turn(rotation), JointRange::Turn(most)) => {
                let turned = turn(DQuat::IDENTITY, rotation);
                Coordinates::Turn(DQuat::from_scaled_axis(turned.clamp_length_max(f64::from(most))))
            }
            _ => at,
        }
    }
}

impl Coordinates {
    fn count(&self) -> usize {
        match self {
            Self::Held(_) => 0,
            Self::One(_) => 1,
            Self::Two(_) => 2,
            Self::Turn(_) => 3,
            Self::Free(_) => 6,
        }
    }
}

/// Returns the distance of two poses: the larger of the angle in rad and the distance in m.
pub fn distance(a: &Pose, b: &Pose) -> f64 {
    let way = (a.position_m - b.position_m).length();
    turn(a.rotation, b.rotation).length().max(way)
}
