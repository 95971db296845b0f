//! Distances of one pose to many poses of a sequence: see `sinew_core::pose_space::PoseSpace`.

#[cfg(test)]
mod tests;

use glam::{Quat, Vec3};
use sinew_core::math::{self, PI};
use sinew_core::pose_space::{BodyPoses, JointRotations, PoseCoordinates};
use sinew_core::{Body, JointKind, Tree};

use crate::LANES;
use crate::turn::{any_log, select};
use crate::widest::{Work, widest};

/// Poses of a sequence, stored by body, so that [`LANES`] successive poses are compared with a pose at once.
#[derive(Debug, Clone)]
pub struct PoseSequence {
    quantity: Quantity,
    len: usize,
    bodies: usize,
    /// For each body, the first component in all poses, then the next component. [`LANES`] numbers follow each list, so
    /// that lanes may begin at every pose.
    numbers: Vec<f32>,
}

/// The compared quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Quantity {
    Angles,
    Rotations,
    Positions,
}

impl PoseSequence {
    /// Stores poses of a tree for distances like
    /// [`angle_distance`](sinew_core::pose_space::PoseSpace::angle_distance). Returns `None` if the tree has other
    /// joints than ball joints and fixed joints.
    pub fn of_angles<'p, const N: usize>(
        tree: &Tree<N>,
        poses: impl ExactSizeIterator<Item = &'p PoseCoordinates<N>>,
    ) -> Option<Self> {
        let is_ball = |body: &Body| matches!(body.joint, JointKind::Spherical | JointKind::Fixed);
        let vectors = poses.map(|pose| pose.as_slice().iter().map(|at| at.angular_rad.to_array()));
        tree.bodies().iter().all(is_ball).then(|| Self::new(Quantity::Angles, vectors))
    }

    /// Stores poses for distances like
    /// [`rotation_distance`](sinew_core::pose_space::PoseSpace::rotation_distance).
    pub fn of_rotations<'p, const N: usize>(
        poses: impl ExactSizeIterator<Item = &'p JointRotations<N>>,
    ) -> Self {
        let rotations = poses.map(|pose| pose.as_slice().iter().map(Quat::to_array));
        Self::new(Quantity::Rotations, rotations)
    }

    /// Stores poses for distances like
    /// [`position_distance`](sinew_core::pose_space::PoseSpace::position_distance).
    pub fn of_positions<'p, const N: usize>(
        poses: impl ExactSizeIterator<Item = &'p BodyPoses<N>>,
    ) -> Self {
        Self::new(Quantity::Positions, poses.map(|pose| pose.positions_m().map(|at| at.to_array())))
    }

    fn new<const C: usize, P: ExactSizeIterator<Item = [f32; C]>>(
        quantity: Quantity,
        poses: impl ExactSizeIterator<Item = P>,
    ) -> Self {
        let (len, mut bodies, mut numbers) = (poses.len(), 0, Vec::new());
        let stride = len + LANES;
        for (index, pose) in poses.enumerate() {
            if index == 0 {
                bodies = pose.len();
                numbers = vec![0.0; bodies * C * stride];
            }
            assert!(pose.len() == bodies, "poses of the same tree");
            for (body, components) in pose.enumerate() {
                for (k, number) in components.into_iter().enumerate() {
                    numbers[(body * C + k) * stride + index] = number;
                }
            }
        }
        Self { quantity, len, bodies, numbers }
    }

    /// Returns the distances of a pose of another sequence to the poses from `first` on, with a weight for each body.
    /// Each distance has the bits of the core's function. Distances to poses after the end have no meaning. O(n).
    ///
    /// # Panics
    /// If the sequences are of different quantities or bodies, there are other weights than bodies, or a pose does not
    /// exist.
    pub fn distances(
        &self,
        first: usize,
        (other, pose): (&Self, usize),
        weights: &[f32],
    ) -> [f32; LANES] {
        widest(Distances::new(self, first, (other, pose), weights))
    }

    /// Returns component `place` of all poses.
    #[inline(always)]
    fn column(&self, place: usize) -> &[f32] {
        let stride = self.len + LANES;
        &self.numbers[place * stride..][..stride]
    }

    /// Returns a component in successive poses.
    #[inline(always)]
    fn lanes(&self, place: usize, first: usize) -> &[f32; LANES] {
        self.column(place)[first..].first_chunk().expect("numbers follow the last pose")
    }
}

struct Distances<'a> {
    sequence: &'a PoseSequence,
    first: usize,
    other: &'a PoseSequence,
    pose: usize,
    weights: &'a [f32],
}

impl<'a> Distances<'a> {
    fn new(
        sequence: &'a PoseSequence,
        first: usize,
        (other, pose): (&'a PoseSequence, usize),
        weights: &'a [f32],
    ) -> Self {
        assert!(first < sequence.len && pose < other.len, "poses of the sequences");
        let are_alike = sequence.quantity == other.quantity && sequence.bodies == other.bodies;
        assert!(are_alike && weights.len() == sequence.bodies, "alike sequences and their weights");
        Self { sequence, first, other, pose, weights }
    }
}

impl Work for Distances<'_> {
    type Output = [f32; LANES];

    #[inline(always)]
    fn run(self) -> [f32; LANES] {
        let mut squares = [0.0; LANES];
        match self.sequence.quantity {
            Quantity::Angles => self.add(&mut squares, shortest_way),
            Quantity::Positions => self.add(&mut squares, |from, to| from - to),
            Quantity::Rotations => self.add_rotations(&mut squares),
        }
        for square in &mut squares {
            *square = square.sqrt();
        }
        squares
    }
}

impl Distances<'_> {
    /// Adds the weighted squares of the lengths of the ways from vectors to vectors.
    #[inline(always)]
    fn add(&self, squares: &mut [f32; LANES], way: impl Fn(Vec3, Vec3) -> Vec3) {
        let Self { sequence, first, other, pose, weights } = self;
        for (body, weight) in weights.iter().enumerate() {
            let place = 3 * body;
            let [fx, fy, fz] = [0, 1, 2].map(|k| other.column(place + k)[*pose]);
            let from = Vec3::new(fx, fy, fz);
            let [x, y, z] = [0, 1, 2].map(|k| sequence.lanes(place + k, *first));
            for lane in 0..LANES {
                let way = way(from, Vec3::new(x[lane], y[lane], z[lane]));
                squares[lane] += weight * way.dot(way);
            }
        }
    }

    /// Adds the weighted squares of the angles between rotations.
    #[inline(always)]
    fn add_rotations(&self, squares: &mut [f32; LANES]) {
        let Self { sequence, first, other, pose, weights } = self;
        for (body, weight) in weights.iter().enumerate() {
            let place = 4 * body;
            let from = Quat::from_array([0, 1, 2, 3].map(|k| other.column(place + k)[*pose]));
            let [x, y, z, w] = [0, 1, 2, 3].map(|k| sequence.lanes(place + k, *first));
            for lane in 0..LANES {
                let to = Quat::from_xyzw(x[lane], y[lane], z[lane], w[lane]);
                let turn = any_log(math::turn_in_body(from, to));
                squares[lane] += weight * turn.dot(turn);
            }
        }
    }
}

/// Returns the shortest way from a rotation vector to one of the vectors of a rotation: the step of the core's straight
/// line in coordinates.
#[inline(always)]
fn shortest_way(from_rad: Vec3, to_rad: Vec3) -> Vec3 {
    let direct = to_rad - from_rad;
    let (from_squared, to_squared) = (from_rad.dot(from_rad), to_rad.dot(to_rad));
    let mut is_direct = from_rad.dot(to_rad) >= 0.0;
    is_direct |= from_squared.max(to_squared) < (0.5 * PI) * (0.5 * PI);
    let other = |vector: Vec3, squared: f32| {
        let angle = squared.sqrt();
        let other = vector * ((angle - 2.0 * PI) / angle);
        choose(angle > 0.0, other, vector)
    };
    let by_from = to_rad - other(from_rad, from_squared);
    let by_to = other(to_rad, to_squared) - from_rad;
    let shorter = |a: Vec3, b: Vec3| choose(b.dot(b) < a.dot(a), b, a);
    choose(is_direct, direct, shorter(direct, shorter(by_from, by_to)))
}

/// Returns the first vector if the condition holds, otherwise the second.
#[inline(always)]
fn choose(condition: bool, first: Vec3, second: Vec3) -> Vec3 {
    Vec3::new(
        select(condition, first.x, second.x),
        select(condition, first.y, second.y),
        select(condition, first.z, second.z),
    )
}
