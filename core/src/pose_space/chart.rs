//! Coordinates of a joint: conversion from and to poses, steps across the wrap-around of angles, and their derivative
//! with respect to the motion of bodies.

use core::ops::{Add, Mul, Sub};

use glam::{Mat3, Quat, Vec3};

use crate::joint::JointKind;
use crate::math::{self, PI};
use crate::transform::{Transform, Twist};
use crate::tree::Body;

/// Coordinates of a joint in its joint frame: numbers that can be interpolated linearly.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointCoordinates {
    /// Rotation vector (spherical, free), axis times angle (revolute), or first axis times first angle plus second
    /// axis times second angle (universal), rad.
    pub angular_rad: Vec3,
    /// Axis times displacement (prismatic), or position (free), m.
    pub linear_m: Vec3,
}

impl JointCoordinates {
    /// Coordinates of a joint whose body is at the joint's placement.
    pub const ZERO: Self = Self { angular_rad: Vec3::ZERO, linear_m: Vec3::ZERO };

    /// Returns `|angular|² + |linear|²`, in rad² and m².
    pub(super) fn squared(self) -> f32 {
        self.angular_rad.dot(self.angular_rad) + self.linear_m.dot(self.linear_m)
    }
}

impl Add for JointCoordinates {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            angular_rad: self.angular_rad + other.angular_rad,
            linear_m: self.linear_m + other.linear_m,
        }
    }
}

impl Sub for JointCoordinates {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self {
            angular_rad: self.angular_rad - other.angular_rad,
            linear_m: self.linear_m - other.linear_m,
        }
    }
}

impl Mul<f32> for JointCoordinates {
    type Output = Self;

    fn mul(self, factor: f32) -> Self {
        Self { angular_rad: self.angular_rad * factor, linear_m: self.linear_m * factor }
    }
}

/// Returns the coordinates of the valid pose nearest to a pose in the parent's frame. Angles are in [-π, π].
pub(super) fn coordinates(body: &Body, pose: &Transform) -> JointCoordinates {
    let in_joint = body.placement.inverse() * *pose;
    let [a, b] = body.joint.along(&in_joint);
    let (angular_rad, linear_m) = match body.joint {
        JointKind::Fixed => (Vec3::ZERO, Vec3::ZERO),
        JointKind::Revolute { axis } => (axis * a, Vec3::ZERO),
        JointKind::Prismatic { axis } => (Vec3::ZERO, axis * a),
        JointKind::Universal { first, second } => (first * a + second * b, Vec3::ZERO),
        JointKind::Spherical => (math::log(in_joint.rotation), Vec3::ZERO),
        JointKind::Free => (math::log(in_joint.rotation), in_joint.translation_m),
    };
    JointCoordinates { angular_rad, linear_m }
}

/// Returns the pose of a joint in its parent's frame.
pub(super) fn pose(body: &Body, at: &JointCoordinates) -> Transform {
    body.placement * Transform::new(rotation(body.joint, at.angular_rad), at.linear_m)
}

fn rotation(kind: JointKind, angular_rad: Vec3) -> Quat {
    match kind {
        JointKind::Universal { first, second } => {
            let turn = |axis: Vec3| math::exp(axis * axis.dot(angular_rad));
            turn(first) * turn(second)
        }
        _ => math::exp(angular_rad),
    }
}

/// Returns the shortest straight line from one pose of a joint to another in coordinates: its start and its step.
/// Rotations have several coordinates each; the pair with the shortest step is used.
pub(super) fn way(
    kind: JointKind,
    from: &JointCoordinates,
    to: &JointCoordinates,
) -> (JointCoordinates, JointCoordinates) {
    let difference = to.angular_rad - from.angular_rad;
    let (start, angular_rad) = match kind {
        JointKind::Revolute { axis } => {
            (from.angular_rad, axis * nearer_angle(axis.dot(difference)))
        }
        JointKind::Universal { first, second } => {
            let step = |axis: Vec3| axis * nearer_angle(axis.dot(difference));
            (from.angular_rad, step(first) + step(second))
        }
        JointKind::Spherical | JointKind::Free => shortest(from.angular_rad, to.angular_rad),
        JointKind::Fixed | JointKind::Prismatic { .. } => (Vec3::ZERO, Vec3::ZERO),
    };
    (
        JointCoordinates { angular_rad: start, linear_m: from.linear_m },
        JointCoordinates { angular_rad, linear_m: to.linear_m - from.linear_m },
    )
}

/// Wraps a difference of two angles, each in [-π, π], to at most half a turn in either direction.
fn nearer_angle(angle_rad: f32) -> f32 {
    if angle_rad > PI {
        angle_rad - 2.0 * PI
    } else if angle_rad < -PI {
        angle_rad + 2.0 * PI
    } else {
        angle_rad
    }
}

/// Returns start and step of the shortest line from a rotation vector of one rotation to a rotation vector of another.
/// Every rotation except the identity has a second vector, for the turn in the opposite direction. This second vector
/// replaces one of the two vectors if that shortens the line.
fn shortest(from_rad: Vec3, to_rad: Vec3) -> (Vec3, Vec3) {
    let direct = to_rad - from_rad;
    let (from_squared, to_squared) = (from_rad.dot(from_rad), to_rad.dot(to_rad));
    // In these cases no second vector can give a shorter line.
    if from_rad.dot(to_rad) >= 0.0 || from_squared.max(to_squared) < (0.5 * PI) * (0.5 * PI) {
        return (from_rad, direct);
    }
    let other = |vector: Vec3, squared: f32| {
        let angle = math::sqrt(squared);
        // The identity has no second vector, and needs none.
        if angle > 0.0 { vector * ((angle - 2.0 * PI) / angle) } else { vector }
    };
    let other_from = other(from_rad, from_squared);
    let by_from = (other_from, to_rad - other_from);
    let by_to = (from_rad, other(to_rad, to_squared) - from_rad);
    let shorter =
        |a: (Vec3, Vec3), b: (Vec3, Vec3)| if b.1.dot(b.1) < a.1.dot(a.1) { b } else { a };
    shorter((from_rad, direct), shorter(by_from, by_to))
}

/// Converts a gradient with respect to motions in body axes to a gradient with respect to coordinates.
pub(super) fn gradient(body: &Body, at: &JointCoordinates, of_motion: &Twist) -> JointCoordinates {
    let turn = rotation(body.joint, at.angular_rad);
    let angular_rad = match body.joint {
        JointKind::Universal { first, second } => {
            let carried = math::rotate(turn.conjugate(), first);
            first * carried.dot(of_motion.angular) + second * second.dot(of_motion.angular)
        }
        _ => right_jacobian(at.angular_rad).transpose() * of_motion.angular,
    };
    JointCoordinates { angular_rad, linear_m: math::rotate(turn, of_motion.linear) }
}

/// Returns the derivative of the exponential map: the body-axes rotation per change of a rotation vector,
/// `I - (1 - cos φ)/φ² [v] + (φ - sin φ)/φ³ [v]²`.
fn right_jacobian(vector_rad: Vec3) -> Mat3 {
    let squared = vector_rad.dot(vector_rad);
    let (of_cross, of_square) = if squared < 0.06 {
        // A series is used, because the differences below would have no digits left.
        (
            0.5 - squared * (1.0 / 24.0 - squared * (1.0 / 720.0)),
            1.0 / 6.0 - squared * (1.0 / 120.0 - squared * (1.0 / 5040.0)),
        )
    } else {
        let angle = math::sqrt(squared);
        let half_sine = math::sin_cos(0.5 * angle).0;
        let (sine, _) = math::sin_cos(angle);
        (2.0 * half_sine * half_sine / squared, (angle - sine) / (squared * angle))
    };
    let cross = Mat3::from_cols(
        Vec3::new(0.0, vector_rad.z, -vector_rad.y),
        Vec3::new(-vector_rad.z, 0.0, vector_rad.x),
        Vec3::new(vector_rad.y, -vector_rad.x, 0.0),
    );
    Mat3::IDENTITY + cross * -of_cross + cross * cross * of_square
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::inertia::Inertia;

    fn body(joint: JointKind) -> Body {
        let placement =
            Transform::new(math::exp(Vec3::new(0.3, -0.2, 0.5)), Vec3::new(0.1, 0.2, 0.3));
        Body { parent: None, joint, placement, inertia: Inertia::default(), rotor_inertia: 0.0 }
    }

    fn kinds() -> [JointKind; 6] {
        let (first, second) = (Vec3::new(0.6, 0.8, 0.0), Vec3::new(-0.8, 0.6, 0.0));
        [
            JointKind::Fixed,
            JointKind::Revolute { axis: first },
            JointKind::Prismatic { axis: second },
            JointKind::Universal { first, second },
            JointKind::Spherical,
            JointKind::Free,
        ]
    }

    /// Returns the coordinates that the joint's kind uses.
    fn some(kind: JointKind, numbers: [f32; 6]) -> JointCoordinates {
        let [a, b, c, d, e, f] = numbers;
        let (turn, way) = (Vec3::new(a, b, c), Vec3::new(d, e, f));
        let (angular_rad, linear_m) = match kind {
            JointKind::Fixed => (Vec3::ZERO, Vec3::ZERO),
            JointKind::Revolute { axis } => (axis * a, Vec3::ZERO),
            JointKind::Prismatic { axis } => (Vec3::ZERO, axis * d),
            JointKind::Universal { first, second } => (first * a + second * b, Vec3::ZERO),
            JointKind::Spherical => (turn, Vec3::ZERO),
            JointKind::Free => (turn, way),
        };
        JointCoordinates { angular_rad, linear_m }
    }

    #[test]
    fn coordinates_of_a_pose_are_those_it_was_made_of() {
        for kind in kinds() {
            let at = some(kind, [0.7, -1.1, 0.4, 0.2, 0.5, -0.3]);
            let back = coordinates(&body(kind), &pose(&body(kind), &at));
            assert!((back - at).squared() < 1e-12, "{kind:?}: {back:?}, {at:?}");
        }
    }

    #[test]
    fn gradients_are_those_of_poses() {
        let step = 1e-2;
        for kind in kinds() {
            for numbers in [[0.02, 0.03, -0.01, 0.2, 0.1, 0.3], [0.7, -1.9, 0.4, 0.2, 0.5, -0.3]] {
                let (body, at) = (body(kind), some(kind, numbers));
                let change = some(kind, [0.3, 0.2, -0.5, 0.4, -0.1, 0.2]);
                let [before, here, after] =
                    [-step, 0.0, step].map(|step| pose(&body, &(at + change * step)));
                let turn = math::log(before.rotation.conjugate() * after.rotation) / (2.0 * step);
                let slide = here.rotation.conjugate()
                    * (after.translation_m - before.translation_m)
                    / (2.0 * step);
                let force = Twist::new(Vec3::new(0.3, 0.8, -0.2), Vec3::new(-0.4, 0.1, 0.6));
                let expected = turn.dot(force.angular) + slide.dot(force.linear);
                let gradient = gradient(&body, &at, &force);
                let got = gradient.angular_rad.dot(change.angular_rad)
                    + gradient.linear_m.dot(change.linear_m);
                // Tolerance: third derivatives in a central difference, and f32 rounding of the poses.
                assert!((got - expected).abs() < 2e-4, "{kind:?}: {got} {expected}");
            }
        }
    }

    #[test]
    fn the_way_goes_across_the_seam() {
        let axis = Vec3::Z;
        let kind = JointKind::Revolute { axis };
        let at = |angle: f32| JointCoordinates { angular_rad: axis * angle, linear_m: Vec3::ZERO };
        let across = way(kind, &at(3.0), &at(-3.0)).1.angular_rad.z;
        assert!((across - (2.0 * PI - 6.0)).abs() < 1e-6);
        let across = way(JointKind::Spherical, &at(3.0), &at(-3.0)).1.angular_rad.z;
        assert!((across - (2.0 * PI - 6.0)).abs() < 1e-5);
        let along = way(JointKind::Spherical, &at(0.5), &at(-1.0)).1.angular_rad.z;
        assert!((along + 1.5).abs() < 1e-6);
    }
}
