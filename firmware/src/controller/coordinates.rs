//! Access to a rig's coordinates by parts: numbers and rotations.

use heapless::Vec;
use sinew_core::glam::{Quat, Vec3};
use sinew_core::{JointKind, Tree, math};

/// A part of the coordinates. A ball joint is a `Turn`, a free joint is a `Turn` and three `Number`s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum JointIndices {
    /// A number for a dof, with its indices in `q` and among the dofs.
    Number { q: usize, v: usize },
    /// A quaternion for three dofs, with the first index in `q` and among the dofs.
    Turn { q: usize, v: usize },
}

/// Returns all parts of a tree's coordinates, or `None` if there are more dofs than `DOFS`.
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

/// Returns the number at an index, or 0.
pub(super) fn number(numbers: &[f32], at: usize) -> f32 {
    numbers.get(at).copied().unwrap_or(0.0)
}

/// Stores a number at an index.
pub(super) fn put(numbers: &mut [f32], at: usize, number: f32) {
    if let Some(slot) = numbers.get_mut(at) {
        *slot = number;
    }
}

/// Returns three numbers, from an index on; zeros if there are fewer.
pub(super) fn three(numbers: &[f32], at: usize) -> Vec3 {
    match numbers.get(at..at.saturating_add(3)) {
        Some(&[x, y, z]) => Vec3::new(x, y, z),
        _ => Vec3::ZERO,
    }
}

/// Stores three numbers, from an index on.
pub(super) fn put_three(numbers: &mut [f32], at: usize, of: Vec3) {
    if let Some(slots) = numbers.get_mut(at..at.saturating_add(3)) {
        slots.iter_mut().zip(of.to_array()).for_each(|(slot, number)| *slot = number);
    }
}

/// Returns the rotation whose quaternion starts at an index; the identity if numbers are missing.
pub(super) fn turn(numbers: &[f32], at: usize) -> Quat {
    match numbers.get(at..at.saturating_add(4)) {
        Some(&[x, y, z, w]) => math::unit(Quat::from_xyzw(x, y, z, w)),
        _ => Quat::IDENTITY,
    }
}

/// Stores a rotation as a quaternion, from an index on.
pub(super) fn put_turn(numbers: &mut [f32], at: usize, of: Quat) {
    if let Some(slots) = numbers.get_mut(at..at.saturating_add(4)) {
        slots.iter_mut().zip(of.to_array()).for_each(|(slot, number)| *slot = number);
    }
}

/// Returns the shorter rotation from one orientation to another, as a rotation vector in body axes, rad.
pub(super) fn between(from: Quat, to: Quat) -> Vec3 {
    math::log(math::unit(from.conjugate() * to))
}
