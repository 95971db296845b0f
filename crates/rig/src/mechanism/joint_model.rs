//! Kinds of joints in f64, with their coordinates.

use glam::{DQuat, DVec3};
use sinew_core::JointKind;

use super::Pose;

/// Kind of motion that a joint permits, with its axes in f64.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointModel {
    /// No motion.
    Fixed,
    /// Rotation about a unit axis of the joint frame.
    Revolute(DVec3),
    /// Translation along a unit axis of the joint frame.
    Prismatic(DVec3),
    /// Rotation about a unit axis of the joint frame, then about a unit axis of the body.
    Universal([DVec3; 2]),
    /// Rotation about any axis.
    Spherical,
    /// Any rotation and translation.
    Free,
}

impl JointModel {
    /// Converts to the kind of `sinew-core`, in f32.
    pub fn kind(self) -> JointKind {
        match self {
            Self::Fixed => JointKind::Fixed,
            Self::Revolute(axis) => JointKind::Revolute { axis: axis.as_vec3().normalize() },
            Self::Prismatic(axis) => JointKind::Prismatic { axis: axis.as_vec3().normalize() },
            Self::Universal([first, second]) => JointKind::Universal {
                first: first.as_vec3().normalize(),
                second: second.as_vec3().normalize(),
            },
            Self::Spherical => JointKind::Spherical,
            Self::Free => JointKind::Free,
        }
    }

    /// Returns the coordinates of the zero pose: zeros, and the identity as a quaternion.
    pub fn zero(self) -> Vec<f64> {
        let mut q = vec![0.0; self.kind().coordinate_count()];
        if let (Self::Spherical | Self::Free, Some(w)) = (self, q.get_mut(3)) {
            *w = 1.0;
        }
        q
    }

    /// Returns the pose of the body in the joint frame at coordinates in the order of `sinew-core`; the identity if
    /// there are too few coordinates.
    pub fn motion(self, q: &[f64]) -> Pose {
        let turn = DQuat::from_axis_angle;
        let turned = |rotation| Pose { rotation, ..Pose::IDENTITY };
        match (self, q) {
            (Self::Revolute(axis), &[angle, ..]) => turned(turn(axis, angle)),
            (Self::Prismatic(axis), &[way, ..]) => {
                Pose { position_m: axis * way, ..Pose::IDENTITY }
            }
            (Self::Universal([first, second]), &[a, b, ..]) => {
                turned(turn(first, a) * turn(second, b))
            }
            (Self::Spherical, &[x, y, z, w, ..]) => turned(DQuat::from_xyzw(x, y, z, w)),
            (Self::Free, &[x, y, z, w, px, py, pz, ..]) => {
                Pose { rotation: DQuat::from_xyzw(x, y, z, w), position_m: DVec3::new(px, py, pz) }
            }
            _ => Pose::IDENTITY,
        }
    }

    /// Returns the position along each axis (rad or m) of a joint with one or two axes, at the joint's pose that is
    /// nearest to `in_joint`; zeros for the other kinds. Angles are in [-π, π].
    pub fn along(self, in_joint: &Pose) -> [f64; 2] {
        let turn_about = |axis: DVec3, rotation: DQuat| {
            let q = if rotation.w < 0.0 { -rotation } else { rotation };
            2.0 * libm::atan2(q.xyz().dot(axis), q.w)
        };
        match self {
            Self::Revolute(axis) => [turn_about(axis, in_joint.rotation), 0.0],
            Self::Prismatic(axis) => [axis.dot(in_joint.position_m), 0.0],
            Self::Universal([first, second]) => {
                let turned = in_joint.rotation * second;
                let angle = libm::atan2(first.cross(second).dot(turned), second.dot(turned));
                let rest = DQuat::from_axis_angle(first, -angle) * in_joint.rotation;
                [angle, turn_about(second, rest)]
            }
            Self::Fixed | Self::Spherical | Self::Free => [0.0; 2],
        }
    }

    /// Returns the axes of the dofs in body axes at given coordinates: first of rotations, then of translations.
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
