//! Where the bodies are, for given joint coordinates.

use glam::{DQuat, DVec3};

use super::{Freedom, Link, Mechanism};

/// A pose in the world: rotation from the body to the world, and its origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPose {
    /// Unit.
    pub rotation: DQuat,
    /// m.
    pub position_m: DVec3,
}

impl BodyPose {
    /// A point of the body, in the world.
    pub fn point(&self, in_body_m: DVec3) -> DVec3 {
        self.position_m + self.rotation * in_body_m
    }
}

impl Mechanism {
    /// Number of joint coordinates: `q` has as many.
    pub fn coordinate_count(&self) -> usize {
        self.bodies.iter().map(|link| link.joint.kind().coordinate_count()).sum()
    }

    /// Where in `q` the coordinates of each joint are.
    pub fn coordinate_ranges(&self) -> Vec<std::ops::Range<usize>> {
        let mut end = 0;
        let of_link = |link: &Link| {
            let start = end;
            end += link.joint.kind().coordinate_count();
            start..end
        };
        self.bodies.iter().map(of_link).collect()
    }

    /// World poses of the bodies. `q`: as [`Mechanism::home`]; numbers that are not there count as zero. O(n).
    pub fn poses(&self, q: &[f64]) -> Vec<BodyPose> {
        let mut poses: Vec<BodyPose> = Vec::with_capacity(self.bodies.len());
        for (link, range) in self.bodies.iter().zip(self.coordinate_ranges()) {
            let (turn, way_m) = link.joint.motion(q.get(range).unwrap_or_default());
            let rotation = link.rotation * turn;
            let position_m = link.position_m + link.rotation * way_m;
            let pose = match link.parent.and_then(|parent| poses.get(parent)) {
                Some(parent) => BodyPose {
                    rotation: (parent.rotation * rotation).normalize(),
                    position_m: parent.point(position_m),
                },
                None => BodyPose { rotation, position_m },
            };
            poses.push(pose);
        }
        poses
    }

    /// Whether joint `joint` moves body `body`: κ of the body has the joint. O(depth).
    pub fn supports(&self, joint: usize, body: usize) -> bool {
        let up = |body: &usize| self.bodies.get(*body).and_then(|link| link.parent);
        std::iter::successors(Some(body), up).any(|body| body == joint)
    }
}

impl Freedom {
    /// Rotation and way of the body in the joint frame.
    pub fn motion(self, q: &[f64]) -> (DQuat, DVec3) {
        let still = (DQuat::IDENTITY, DVec3::ZERO);
        match (self, q) {
            (Self::Revolute(axis), &[angle]) => (DQuat::from_axis_angle(axis, angle), DVec3::ZERO),
            (Self::Prismatic(axis), &[way]) => (DQuat::IDENTITY, axis * way),
            (Self::Universal([first, second]), &[a, b]) => {
                (DQuat::from_axis_angle(first, a) * DQuat::from_axis_angle(second, b), DVec3::ZERO)
            }
            (Self::Spherical, &[x, y, z, w]) => (DQuat::from_xyzw(x, y, z, w), DVec3::ZERO),
            (Self::Free, &[x, y, z, w, px, py, pz]) => {
                (DQuat::from_xyzw(x, y, z, w), DVec3::new(px, py, pz))
            }
            _ => still,
        }
    }

    /// Axes of the freedoms in body axes at given coordinates: of turns, then of slides.
    pub fn axes(self, q: &[f64]) -> (Vec<DVec3>, Vec<DVec3>) {
        match self {
            Self::Fixed => (vec![], vec![]),
            Self::Revolute(axis) => (vec![axis], vec![]),
            Self::Prismatic(axis) => (vec![], vec![axis]),
            Self::Universal([first, second]) => {
                let back = q.get(1).map_or(DQuat::IDENTITY, |b| DQuat::from_axis_angle(second, -b));
                (vec![back * first, second], vec![])
            }
            Self::Spherical => (DVec3::AXES.to_vec(), vec![]),
            Self::Free => (DVec3::AXES.to_vec(), DVec3::AXES.to_vec()),
        }
    }
}
