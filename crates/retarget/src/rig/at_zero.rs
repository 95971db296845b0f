//! A rig with every joint at zero: where its bodies and axes are in the world.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Pose};

/// A line of the world about which a joint turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Unit.
    pub(super) direction: DVec3,
    /// A point of it: the joint's own, m.
    pub(super) anchor_m: DVec3,
}

impl Axis {
    /// The nearest of its points to another, m.
    pub(super) fn nearest_to(&self, point_m: DVec3) -> DVec3 {
        self.anchor_m + self.direction * self.direction.dot(point_m - self.anchor_m)
    }

    /// m.
    pub(super) fn distance_to(&self, point_m: DVec3) -> f64 {
        (point_m - self.nearest_to(point_m)).length()
    }
}

/// A rig with every joint at zero.
#[derive(Debug)]
pub(super) struct AtZero<'m> {
    pub(super) mechanism: &'m Mechanism,
    pub(super) poses: Vec<Pose>,
    /// Largest distance of two joints, m.
    pub(super) size_m: f64,
}

impl<'m> AtZero<'m> {
    pub(super) fn of(mechanism: &'m Mechanism) -> Self {
        let zero: Vec<f64> = mechanism.bodies.iter().flat_map(|link| link.joint.zero()).collect();
        let poses = mechanism.poses(&zero);
        let mut size_m: f64 = 0.0;
        for (k, one) in poses.iter().enumerate() {
            for other in &poses[..k] {
                size_m = size_m.max(one.position_m.distance(other.position_m));
            }
        }
        Self { mechanism, poses, size_m }
    }

    pub(super) fn parent(&self, body: usize) -> Option<usize> {
        self.mechanism.bodies[body].parent
    }

    /// The lines that a joint turns about; none of a slide.
    pub(super) fn axes(&self, body: usize) -> Vec<Axis> {
        let pose = &self.poses[body];
        let world =
            |axis: DVec3| Axis { direction: pose.rotation * axis, anchor_m: pose.position_m };
        match self.mechanism.bodies[body].joint {
            JointModel::Revolute(axis) => vec![world(axis)],
            JointModel::Universal([first, second]) => vec![world(first), world(second)],
            JointModel::Spherical => DVec3::AXES.map(world).to_vec(),
            JointModel::Fixed | JointModel::Prismatic(_) | JointModel::Free => Vec::new(),
        }
    }

    /// From a body to the base, itself first.
    pub(super) fn way_to_base(&self, body: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(body), |body| self.parent(*body))
    }

    /// The body that carries both.
    pub(super) fn common_body(&self, one: usize, other: usize) -> usize {
        let of_one: Vec<usize> = self.way_to_base(one).collect();
        self.way_to_base(other).find(|body| of_one.contains(body)).unwrap_or(0)
    }

    /// Whether one body hangs on another, or is it.
    pub(super) fn moves_with(&self, body: usize, ancestor: usize) -> bool {
        self.way_to_base(body).any(|above| above == ancestor)
    }
}

/// The point where lines nearly meet: least squares, drawn weakly to `towards_m` where they leave it open.
pub(super) fn meeting_point(axes: &[Axis], towards_m: DVec3, weight: f64) -> DVec3 {
    let mut matrix = glam::DMat3::from_diagonal(DVec3::splat(weight));
    let mut right = towards_m * weight;
    for Axis { direction, anchor_m } in axes {
        let across = glam::DMat3::IDENTITY
            - glam::DMat3::from_cols(
                *direction * direction.x,
                *direction * direction.y,
                *direction * direction.z,
            );
        matrix += across;
        right += across * *anchor_m;
    }
    matrix.inverse() * right
}
