//! A rig with every joint at zero: poses of its bodies and axes in the world.

use glam::DVec3;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Pose};

/// A line in the world about which a joint turns.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Axis {
    /// Unit direction.
    pub(super) direction: DVec3,
    /// A point of the line: the position of the joint, m.
    pub(super) anchor_m: DVec3,
}

impl Axis {
    /// Returns the point of the line that is nearest to another point, m.
    pub(super) fn nearest_to(&self, point_m: DVec3) -> DVec3 {
        self.anchor_m + self.direction * self.direction.dot(point_m - self.anchor_m)
    }

    /// Returns the distance from a point, m.
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

    /// Returns the lines that a joint turns about; empty for a slide.
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

    /// Returns the bodies from a body to the base, both included.
    pub(super) fn way_to_base(&self, body: usize) -> impl Iterator<Item = usize> {
        std::iter::successors(Some(body), |body| self.parent(*body))
    }

    /// Returns the last body that the paths of both bodies to the base have in common.
    pub(super) fn common_body(&self, one: usize, other: usize) -> usize {
        let of_one: Vec<usize> = self.way_to_base(one).collect();
        self.way_to_base(other).find(|body| of_one.contains(body)).unwrap_or(0)
    }

    /// Returns whether `body` is `ancestor`, or a descendant of it.
    pub(super) fn moves_with(&self, body: usize, ancestor: usize) -> bool {
        self.way_to_base(body).any(|above| above == ancestor)
    }
}

/// Returns the point nearest to all lines by least squares. In directions that the lines do not determine, `towards_m`
/// determines the point, by a term with the small weight `weight`.
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
