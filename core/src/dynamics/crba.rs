//! The composite-rigid-body algorithm.

use glam::{Mat3, Vec3};

use super::body_axes::in_body_axes;
use super::rigid_inertia::RigidInertia;
use crate::joint::JointKind;
use crate::state::JointState;
use crate::transform::Wrench;
use crate::tree::Body;

/// A body with all bodies beyond it, held together: scratch of [`mass_matrix`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompositeBody {
    parent: Option<usize>,
    to_parent: Mat3,
    /// The body's origin in the parent's axes.
    arm_m: Vec3,
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
            parent: None,
            to_parent: Mat3::IDENTITY,
            arm_m: Vec3::ZERO,
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
            // No parent comes after its child, whatever a hand-made slice says.
            parent: body.parent.filter(|parent| *parent < count),
            to_parent,
            arm_m: joint.pose.translation_m,
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
    for (index, body) in bodies.iter().take(count).enumerate().rev() {
        let Some((inner, [this, ..])) = scratch.split_at_mut_checked(index) else { break };
        if let Some(parent) = this.parent.and_then(|parent| inner.get_mut(parent)) {
            let in_parent = this.inertia.turned(&this.to_parent).moved(this.arm_m);
            parent.inertia = parent.inertia.plus(&in_parent);
        }
        let CompositeBody { joint, first, inertia, .. } = *this;
        match joint {
            JointKind::Fixed => {}
            JointKind::Revolute { axis } => {
                matrix.set_rows(first, [inertia.of_turn(axis)], index, scratch);
            }
            JointKind::Prismatic { axis } => {
                matrix.set_rows(first, [inertia.of_slide(axis)], index, scratch);
            }
            JointKind::Universal { first: outer, second } => {
                matrix.set_rows(first, [inertia.of_turn(outer)], index, scratch);
                let row = first.saturating_add(1);
                matrix.set_rows(row, [inertia.of_turn(second)], index, scratch);
            }
            JointKind::Spherical => matrix.set_rows(first, inertia.of_turns(), index, scratch),
            JointKind::Free => {
                matrix.set_rows(first, inertia.of_turns(), index, scratch);
                let row = first.saturating_add(3);
                matrix.set_rows(row, inertia.of_slides(), index, scratch);
            }
        }
        if body.rotor_inertia > 0.0 {
            for row in (first..size).take(joint.degrees_of_freedom()) {
                matrix.add_on_diagonal(row, body.rotor_inertia);
            }
        }
    }
    size
}

/// The matrix, row by row.
struct Square<'a> {
    elements: &'a mut [f32],
    size: usize,
}

impl Square<'_> {
    fn clear(&mut self) {
        self.elements.iter_mut().take(self.size.saturating_mul(self.size)).for_each(|x| *x = 0.0);
    }

    /// Sets rows, one below the other, up to a body's own columns, and the same columns: the forces along the freedoms
    /// of all bodies that carry this one. `wrenches`: what moves all beyond the body along each of its freedoms, about
    /// its origin.
    fn set_rows<const K: usize>(
        &mut self,
        row: usize,
        mut wrenches: [Wrench; K],
        body: usize,
        scratch: &[CompositeBody],
    ) {
        let mut next = Some(body);
        while let Some(this) = next.and_then(|index| scratch.get(index)) {
            match this.joint {
                JointKind::Fixed => {}
                JointKind::Revolute { axis } => {
                    self.set(row, this.first, wrenches.map(|wrench| [axis.dot(wrench.moment_nm)]));
                }
                JointKind::Prismatic { axis } => {
                    self.set(row, this.first, wrenches.map(|wrench| [axis.dot(wrench.force_n)]));
                }
                JointKind::Universal { first, second } => {
                    let along =
                        |wrench: Wrench| [first, second].map(|axis| axis.dot(wrench.moment_nm));
                    self.set(row, this.first, wrenches.map(along));
                }
                JointKind::Spherical => {
                    self.set(row, this.first, wrenches.map(|wrench| wrench.moment_nm.to_array()));
                }
                JointKind::Free => {
                    self.set(row, this.first, wrenches.map(|wrench| wrench.moment_nm.to_array()));
                    let slides = this.first.saturating_add(3);
                    self.set(row, slides, wrenches.map(|wrench| wrench.force_n.to_array()));
                }
            }
            next = this.parent;
            if next.is_some() {
                for wrench in &mut wrenches {
                    let force_n = this.to_parent * wrench.force_n;
                    let moment_nm = this.to_parent * wrench.moment_nm + this.arm_m.cross(force_n);
                    *wrench = Wrench { moment_nm, force_n };
                }
            }
        }
    }

    fn add_on_diagonal(&mut self, row: usize, value: f32) {
        let index = row.saturating_mul(self.size).saturating_add(row);
        if let Some(slot) = self.elements.get_mut(index) {
            *slot += value;
        }
    }

    /// Sets a block and its mirror.
    #[inline]
    fn set<const K: usize, const M: usize>(
        &mut self,
        row: usize,
        column: usize,
        block: [[f32; M]; K],
    ) {
        let mut mirror = [[0.0; K]; M];
        for (k, numbers) in block.iter().enumerate() {
            for (row, number) in mirror.iter_mut().zip(numbers) {
                if let Some(slot) = row.get_mut(k) {
                    *slot = *number;
                }
            }
        }
        self.set_block(row, column, &block);
        self.set_block(column, row, &mirror);
    }

    #[inline]
    fn set_block<const K: usize, const M: usize>(
        &mut self,
        row: usize,
        column: usize,
        block: &[[f32; M]; K],
    ) {
        // Within the matrix, so below its number of elements.
        let mut start = row.wrapping_mul(self.size).wrapping_add(column);
        for numbers in block {
            let place = self.elements.get_mut(start..).and_then(|rest| rest.first_chunk_mut::<M>());
            if let Some(place) = place {
                *place = *numbers;
            }
            start = start.wrapping_add(self.size);
        }
    }
}
