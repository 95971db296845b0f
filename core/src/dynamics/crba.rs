//! The composite-rigid-body algorithm.

use glam::{Mat3, Quat};

use super::body_axes::in_body_axes;
use super::rigid_inertia::RigidInertia;
use crate::joint::JointKind;
use crate::state::JointState;
use crate::transform::Wrench;
use crate::tree::Body;

/// A body with all bodies beyond it, held together: scratch of [`mass_matrix`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompositeBody {
    to_parent: Mat3,
    /// Axes in body axes.
    joint: JointKind,
    /// Row of the joint's first freedom.
    first: usize,
    /// Body axes.
    inertia: RigidInertia,
}

impl Default for CompositeBody {
    /// Contents do not matter.
    fn default() -> Self {
        Self {
            to_parent: Mat3::IDENTITY,
            joint: JointKind::Fixed,
            first: 0,
            inertia: RigidInertia::default(),
        }
    }
}

/// Number of degrees of freedom of all joints together.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform, dynamics::degrees_of_freedom};
/// let body = |parent, joint| {
///     Body { parent, joint, placement: Transform::IDENTITY, inertia: Inertia::default(), rotor_inertia: 0.0 }
/// };
/// let figure = [body(None, JointKind::Free), body(Some(0), JointKind::Spherical)];
/// assert_eq!(degrees_of_freedom(&figure), 9);
/// ```
pub fn degrees_of_freedom(bodies: &[Body]) -> usize {
    bodies.iter().map(|body| body.joint.degrees_of_freedom()).fold(0, usize::saturating_add)
}

/// The joint-space mass matrix H of a pose: `½ q̇ᵀ H q̇` is the kinetic energy, and `H q̈` the forces along
/// all freedoms that accelerate the tree from rest without gravity. The composite-rigid-body algorithm
/// (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 6). O(n · depth), and O(D²) to clear it.
///
/// - Rows and columns: the freedoms of the joints in the order of the bodies, each joint's in the order of
///   the columns of its [`JointKind::motion_subspace`]: angular ones first, in body axes. Units are kg m²
///   between turns, kg between slides, kg m between one and the other.
/// - `joints`: states relative to the parent; only the poses count.
/// - `scratch`: contents do not matter.
/// - `out`: H in full, row by row (it is symmetric to the last bit, so also column by column), in the first
///   D² numbers; what is behind stays.
///
/// Returns D, the [`degrees_of_freedom`] of the bodies that it holds: if a slice is shorter than the tree, or
/// `out` has no room for the square, the bodies beyond are left out, as if they were not there.
///
/// Rotors of the drives add to the diagonal ([`Body::rotor_inertia`]).
///
/// H is positive definite unless some motion of the joints moves no mass and no rotor; then it is singular.
///
/// ```
/// use sinew_core::dynamics::{CompositeBody, mass_matrix};
/// use sinew_core::{Body, Inertia, JointKind, JointStates, RotationalInertia, Transform, Tree, glam::Vec3};
/// // A double pendulum of two weights of 1 kg on arms of 0.5 m, in a line.
/// let link = |parent, x| Body {
///     parent,
///     joint: JointKind::Revolute { axis: Vec3::Z },
///     placement: Transform::from_translation(Vec3::X * x),
///     inertia: Inertia {
///         mass_kg: 1.0,
///         center_of_mass_m: Vec3::X * 0.5,
///         rotational_kg_m2: RotationalInertia::default(),
///     },
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.5)])?;
/// let rest = JointStates::rest(&tree);
/// let mut matrix = [0.0; 4];
/// let mut scratch = [CompositeBody::default(); 2];
/// assert_eq!(mass_matrix(tree.bodies(), rest.as_slice(), &mut scratch, &mut matrix), 2);
/// assert_eq!(matrix, [0.25 + 1.0, 0.5, 0.5, 0.25]);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn mass_matrix(
    bodies: &[Body],
    joints: &[JointState],
    scratch: &mut [CompositeBody],
    out: &mut [f32],
) -> usize {
    let (mut count, mut size) = (0usize, 0usize);
    for ((body, joint), slot) in bodies.iter().zip(joints).zip(scratch.iter_mut()) {
        let end = size.saturating_add(body.joint.degrees_of_freedom());
        if end.saturating_mul(end) > out.len() {
            break;
        }
        let to_parent = Mat3::from_quat(joint.pose.rotation);
        *slot = CompositeBody {
            to_parent,
            joint: in_body_axes(body, &to_parent),
            first: size,
            inertia: RigidInertia::of(&body.inertia),
        };
        (count, size) = (count.saturating_add(1), end);
    }
    let mut matrix = Square { elements: out, size };
    matrix.clear();

    // Inward: a body is whole when all beyond it have been added. (Backwards by index: the way back through
    // several iterators at once would hold a panic.)
    for index in (0..count).rev() {
        let (Some(body), Some(joint), Some((inner, [this, ..]))) =
            (bodies.get(index), joints.get(index), scratch.split_at_mut_checked(index))
        else {
            break;
        };
        let parent = body.parent.and_then(|parent| inner.get_mut(parent));
        if let Some(parent) = parent {
            let in_parent = this.inertia.turned(&this.to_parent).moved(joint.pose.translation_m);
            parent.inertia = parent.inertia.plus(&in_parent);
        }
        let columns = this.joint.motion_subspace(Quat::IDENTITY);
        let (first, inertia) = (this.first, this.inertia);
        for (row, column) in (first..size).zip(&columns) {
            matrix.set_row(row, inertia.wrench(*column), index, bodies, joints, scratch);
            if body.rotor_inertia > 0.0 {
                matrix.add_on_diagonal(row, body.rotor_inertia);
            }
        }
    }
    size
}

/// A square matrix, row by row.
struct Square<'a> {
    elements: &'a mut [f32],
    size: usize,
}

impl Square<'_> {
    fn clear(&mut self) {
        self.elements.iter_mut().take(self.size.saturating_mul(self.size)).for_each(|x| *x = 0.0);
    }

    /// Sets what the freedom `row` of a body's joint, which takes `wrench` on the body, has in common with that
    /// joint and those that carry it; the columns as well.
    fn set_row(
        &mut self,
        row: usize,
        wrench: Wrench,
        body: usize,
        bodies: &[Body],
        joints: &[JointState],
        scratch: &[CompositeBody],
    ) {
        let (mut index, Wrench { mut moment_nm, mut force_n }) = (body, wrench);
        while let (Some(body), Some(joint), Some(this)) =
            (bodies.get(index), joints.get(index), scratch.get(index))
        {
            match this.joint {
                JointKind::Fixed => {}
                JointKind::Revolute { axis } => self.set(row, this.first, &[axis.dot(moment_nm)]),
                JointKind::Prismatic { axis } => self.set(row, this.first, &[axis.dot(force_n)]),
                JointKind::Universal { first, second } => {
                    self.set(row, this.first, &[first.dot(moment_nm), second.dot(moment_nm)]);
                }
                JointKind::Spherical => self.set(row, this.first, &moment_nm.to_array()),
                JointKind::Free => {
                    self.set(row, this.first, &moment_nm.to_array());
                    self.set(row, this.first.saturating_add(3), &force_n.to_array());
                }
            }
            // No parent comes after its child, whatever a hand-made slice says.
            let Some(parent) = body.parent.filter(|parent| *parent < index) else { return };
            force_n = this.to_parent * force_n;
            moment_nm = this.to_parent * moment_nm + joint.pose.translation_m.cross(force_n);
            index = parent;
        }
    }

    fn add_on_diagonal(&mut self, row: usize, value: f32) {
        let index = row.saturating_mul(self.size).saturating_add(row);
        if let Some(slot) = self.elements.get_mut(index) {
            *slot += value;
        }
    }

    /// Sets elements of a row from column `first` on, and their mirror images.
    fn set(&mut self, row: usize, first: usize, values: &[f32]) {
        for (column, value) in (first..self.size).zip(values) {
            for (row, column) in [(row, column), (column, row)] {
                let index = row.saturating_mul(self.size).saturating_add(column);
                if let Some(slot) = self.elements.get_mut(index) {
                    *slot = *value;
                }
            }
        }
    }
}
