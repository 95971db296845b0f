//! Coordinates of a rig in parts: numbers, and rotations.

use heapless::Vec;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{JointKind, Tree, math};

/// A part of the coordinates. A ball joint is a turn, a free one a turn and three numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum JointIndices {
    /// One number for one dof; where they are.
    Number { q: usize, v: usize },
    /// A quaternion for three dofs; where they begin.
    Turn { q: usize, v: usize },
}

/// All parts of a tree's coordinates; none if there are more dofs than `DOFS`.
pub(super) fn parts<const N: usize, const DOFS: usize>(
    tree: &Tree<N>,
) -> Option<Vec<JointIndices, DOFS>> {
    let mut parts = Vec::new();
    let (mut q, mut v) = (0_usize, 0_usize);
    for body in tree.bodies() {
        let (end_q, end_v) = (
            q.saturating_add(body.joint.coordinate_count()),
            v.saturating_add(body.joint.dof_count()),
        );
        if matches!(body.joint, JointKind::Spherical | JointKind::Free) {
            parts.push(JointIndices::Turn { q, v }).ok()?;
            (q, v) = (q.saturating_add(4), v.saturating_add(3));
        }
        for (q, v) in (q..end_q).zip(v..end_v) {
            parts.push(JointIndices::Number { q, v }).ok()?;
        }
        (q, v) = (end_q, end_v);
    }
    (v <= DOFS).then_some(parts)
}

/// The number at a place.
pub(super) fn number(numbers: &[f32], at: usize) -> f32 {
    numbers.get(at).copied().unwrap_or(0.0)
}

/// Puts a number at a place.
pub(super) fn put(numbers: &mut [f32], at: usize, number: f32) {
    if let Some(slot) = numbers.get_mut(at) {
        *slot = number;
    }
}

/// Three numbers from a place on.
pub(super) fn three(numbers: &[f32], at: usize) -> Vec3 {
    match numbers.get(at..at.saturating_add(3)) {
        Some(&[x, y, z]) => Vec3::new(x, y, z),
        _ => Vec3::ZERO,
    }
}

/// Puts three numbers from a place on.
pub(super) fn put_three(numbers: &mut [f32], at: usize, of: Vec3) {
    if let Some(slots) = numbers.get_mut(at..at.saturating_add(3)) {
        slots.iter_mut().zip(of.to_array()).for_each(|(slot, number)| *slot = number);
    }
}

/// The rotation from a place on.
pub(super) fn turn(numbers: &[f32], at: usize) -> Quat {
    match numbers.get(at..at.saturating_add(4)) {
        Some(&[x, y, z, w]) => math::unit(Quat::from_xyzw(x, y, z, w)),
        _ => Quat::IDENTITY,
    }
}

/// Puts a rotation from a place on.
pub(super) fn put_turn(numbers: &mut [f32], at: usize, of: Quat) {
    if let Some(slots) = numbers.get_mut(at..at.saturating_add(4)) {
        slots.iter_mut().zip(of.to_array()).for_each(|(slot, number)| *slot = number);
    }
}

/// The way from one rotation to another, a rotation vector in body axes, rad: the shorter one.
pub(super) fn between(from: Quat, to: Quat) -> Vec3 {
    math::log(math::unit(from.conjugate() * to))
}
