//! The composite-rigid-body algorithm: the mass matrix.

use core::hint::black_box;

use glam::{Mat3, Quat, Vec3};

use super::body_axes::in_body_axes;
use super::rigid_inertia::RigidInertia;
use crate::joint::JointKind;
use crate::math;
use crate::state::JointState;
use crate::transform::Wrench;
use crate::tree::Body;

/// A body rigidly connected to all bodies that it carries: scratch memory of [`mass_matrix`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CompositeBody {
    parent: Option<usize>,
    /// Rotation from body axes to the parent's axes. In the outward pass: to the root's axes; identity for the root.
    turn: Quat,
    /// The rotation `turn` as a matrix, in the outward pass.
    rotation: Mat3,
    /// Vector from the parent's origin to the body's, in the parent's axes. In the outward pass: in the root's axes.
    arm_m: Vec3,
    /// Joint with its axes in body axes. In the outward pass: in the root's axes.
    joint: JointKind,
    /// Row of the joint's first dof.
    first: usize,
    /// Inertia of the body with all bodies that it carries, in body axes.
    inertia: RigidInertia,
}

impl Default for CompositeBody {
    /// Creates an item of scratch memory. Its contents do not matter.
    fn default() -> Self {
        Self {
            parent: None,
            turn: Quat::IDENTITY,
            rotation: Mat3::IDENTITY,
            arm_m: Vec3::ZERO,
            joint: JointKind::Fixed,
            first: 0,
            inertia: RigidInertia::default(),
        }
    }
}

/// Returns the number of dofs of all joints.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, Transform, dynamics::dof_count};
/// let body = |parent, joint| {
///     Body { parent, joint, placement: Transform::IDENTITY, inertia: Inertia::default(), rotor_inertia: 0.0 }
/// };
/// let figure = [body(None, JointKind::Free), body(Some(0), JointKind::Spherical)];
/// assert_eq!(dof_count(&figure), 9);
/// ```
pub fn dof_count(bodies: &[Body]) -> usize {
    bodies.iter().map(|body| body.joint.dof_count()).fold(0, usize::saturating_add)
}

/// Computes the joint-space mass matrix H of a pose: `½ q̇ᵀ H q̇` is the kinetic energy, and `H q̈` are the forces
/// along all dofs that accelerate the tree from rest without gravity. Uses the composite-rigid-body algorithm
/// (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 6). O(n · depth), plus O(D²) to clear the matrix.
///
/// - Rows and columns: the dofs of the joints in the order of the bodies, each joint's dofs in the order of the
///   columns of its [`JointKind::motion_subspace`]: angular dofs first, in body axes. Units are kg m² between
///   rotations, kg between slides, kg m between a rotation and a slide.
/// - `joints`: states relative to the parent; only the poses matter.
/// - `scratch`: contents do not matter.
/// - `out`: the full H, row by row (it is symmetric to the last bit, so also column by column), in the first D²
///   numbers; the rest is unchanged.
///
/// Returns D, the [`dof_count`] of the bodies in H. If a slice is shorter than the tree, or `out` has no room for the
/// square, the remaining bodies are left out, as if they did not exist.
///
/// Rotors of the drives add to the diagonal ([`Body::rotor_inertia`]).
///
/// H is positive definite unless some motion of the joints moves no mass and no rotor. In that case H is singular.
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
        let end = size.saturating_add(body.joint.dof_count());
        if end.saturating_mul(end) > out.len() {
            break;
        }
        *slot = CompositeBody {
            // A parent must precede its child; an invalid parent in a hand-made slice is ignored.
            parent: body.parent.filter(|parent| *parent < count),
            turn: joint.pose.rotation,
            rotation: Mat3::IDENTITY,
            arm_m: joint.pose.translation_m,
            joint: in_body_axes(body, &Mat3::from_quat(joint.pose.rotation)),
            first: size,
            inertia: RigidInertia::of(&body.inertia),
        };
        (count, size) = (count.saturating_add(1), end);
    }
    let mut matrix = Square { elements: out, size };
    matrix.clear();

    // Inward: a body is complete when all bodies beyond it have been added. (A loop backwards by index: reversing
    // several zipped iterators would contain a panic.)
    for index in (0..count).rev() {
        let Some((inner, [this, ..])) = scratch.split_at_mut_checked(index) else { break };
        if let Some(parent) = this.parent.and_then(|parent| inner.get_mut(parent)) {
            let in_parent = this.inertia.turned(&Mat3::from_quat(this.turn)).moved(this.arm_m);
            parent.inertia = parent.inertia.plus(&in_parent);
        }
    }

    // Outward: from now on, the bodies between a body and its root are stored in root axes. Each wrench is then
    // rotated once, not from body to body.
    for (index, body) in bodies.iter().take(count).enumerate() {
        let Some((inner, [this, ..])) = scratch.split_at_mut_checked(index) else { break };
        matrix.set_own_block(this);
        let CompositeBody { joint, first, inertia, .. } = *this;
        if body.rotor_inertia > 0.0 {
            for row in (first..size).take(joint.dof_count()) {
                matrix.add_on_diagonal(row, body.rotor_inertia);
            }
        }
        let Some(parent) = this.parent.and_then(|parent| inner.get(parent)) else {
            this.turn = Quat::IDENTITY;
            this.rotation = Mat3::IDENTITY;
            continue;
        };
        // Composed as quaternions, because a repeated product of matrices drifts away from a rotation.
        this.turn = math::unit(parent.turn * this.turn);
        this.rotation = Mat3::from_quat(this.turn);
        this.arm_m = parent.rotation * this.arm_m;
        let turned = this.rotation;
        match joint {
            JointKind::Fixed => {}
            JointKind::Revolute { axis } => {
                this.joint = JointKind::Revolute { axis: turned * axis };
                matrix.set_row(first, &inertia.of_turn(axis), this, inner);
            }
            JointKind::Prismatic { axis } => {
                this.joint = JointKind::Prismatic { axis: turned * axis };
                matrix.set_row(first, &inertia.of_slide(axis), this, inner);
            }
            JointKind::Universal { first: outer, second } => {
                this.joint =
                    JointKind::Universal { first: turned * outer, second: turned * second };
                matrix.set_row(first, &inertia.of_turn(outer), this, inner);
                matrix.set_row(first.saturating_add(1), &inertia.of_turn(second), this, inner);
            }
            JointKind::Spherical => matrix.set_rows_of_turns(this, inner),
            JointKind::Free => {
                let wrenches = inertia.of_turns().into_iter().chain(inertia.of_slides());
                for (row, wrench) in (first..size).zip(wrenches) {
                    matrix.set_row(row, &wrench, this, inner);
                }
            }
        }
    }
    size
}

/// The mass matrix, row by row.
struct Square<'a> {
    elements: &'a mut [f32],
    size: usize,
}

impl Square<'_> {
    fn clear(&mut self) {
        let len = self.size.saturating_mul(self.size);
        let Some(elements) = self.elements.get_mut(..len) else { return };
        // Zeros are copied through `black_box`. Otherwise the compiler would call `memset`, which takes three times
        // as long.
        let zeros = black_box([0.0; 16]);
        let mut chunks = elements.chunks_exact_mut(zeros.len());
        for place in chunks.by_ref().filter_map(|chunk| chunk.first_chunk_mut()) {
            *place = zeros;
        }
        chunks.into_remainder().fill(0.0);
    }

    /// Sets the block that couples a body's dofs with each other.
    #[inline]
    fn set_own_block(&mut self, body: &CompositeBody) {
        let CompositeBody { joint, first, inertia, .. } = *body;
        match joint {
            JointKind::Fixed => {}
            JointKind::Revolute { axis } => {
                self.set_block(first, first, &[[axis.dot(inertia.of_turn(axis).moment_nm)]]);
            }
            JointKind::Prismatic { axis } => {
                self.set_block(first, first, &[[axis.dot(inertia.of_slide(axis).force_n)]]);
            }
            JointKind::Universal { first: outer, second } => {
                let [by_outer, by_second] =
                    [outer, second].map(|axis| inertia.of_turn(axis).moment_nm);
                let both = outer.dot(by_second);
                let block = [[outer.dot(by_outer), both], [both, second.dot(by_second)]];
                self.set_block(first, first, &block);
            }
            JointKind::Spherical => {
                self.set_block(first, first, &inertia.of_turns().map(|turn| turn.moment_nm.into()));
            }
            JointKind::Free => {
                let (turns, slides) = (inertia.of_turns(), first.saturating_add(3));
                let forces = turns.map(|turn| turn.force_n.to_array());
                self.set_block(first, first, &turns.map(|turn| turn.moment_nm.into()));
                self.set_block(first, slides, &forces);
                self.set_block(slides, first, &transposed(&forces));
                let by_slides = inertia.of_slides().map(|slide| slide.force_n.into());
                self.set_block(slides, slides, &by_slides);
            }
        }
    }

    /// Sets a row up to a body's own columns, and the mirrored column: the forces along the dofs of all bodies that
    /// carry this body. `wrench` is the wrench that accelerates the subtree along the row's dof, about the body's
    /// origin, in the body's axes.
    #[inline(never)]
    fn set_row(
        &mut self,
        row: usize,
        wrench: &Wrench,
        body: &CompositeBody,
        inner: &[CompositeBody],
    ) {
        let start = row.wrapping_mul(self.size);
        let Some((above, rows)) = self.elements.split_at_mut_checked(start) else { return };
        let Some(columns) = rows.get_mut(..body.first) else { return };
        let rows = Rows { above, size: self.size, first: row, columns: [columns] };
        let turned = |v: Vec3| [body.rotation * v];
        rows.set(turned(wrench.moment_nm), turned(wrench.force_n), body, inner);
    }

    /// Sets the rows of all three rotations of a body, like [`Self::set_row`].
    #[inline(never)]
    fn set_rows_of_turns(&mut self, body: &CompositeBody, inner: &[CompositeBody]) {
        let (size, first) = (self.size, body.first);
        let start = first.wrapping_mul(size);
        let Some((above, rows)) = self.elements.split_at_mut_checked(start) else { return };
        let Some((x_row, rows)) = rows.split_at_mut_checked(size) else { return };
        let Some((y_row, z_row)) = rows.split_at_mut_checked(size) else { return };
        // Cut to equal length: one bounds check then serves all three.
        let (Some(x_row), Some(y_row), Some(z_row)) =
            (x_row.get_mut(..first), y_row.get_mut(..first), z_row.get_mut(..first))
        else {
            return;
        };
        let rows = Rows { above, size, first, columns: [x_row, y_row, z_row] };

        let RigidInertia { first_moment_kg_m: Vec3 { x, y, z }, rotational_kg_m2, .. } =
            body.inertia;
        let turned = body.rotation;
        let moments = [
            turned * rotational_kg_m2.x_axis(),
            turned * rotational_kg_m2.y_axis(),
            turned * rotational_kg_m2.z_axis(),
        ];
        // Equal to [`RigidInertia::of_turns`], without its zeros.
        let Mat3 { x_axis, y_axis, z_axis } = turned;
        let forces = [z_axis * y - y_axis * z, x_axis * z - z_axis * x, y_axis * x - x_axis * y];
        rows.set(moments, forces, body, inner);
    }

    fn add_on_diagonal(&mut self, row: usize, value: f32) {
        let index = row.saturating_mul(self.size).saturating_add(row);
        if let Some(slot) = self.elements.get_mut(index) {
            *slot += value;
        }
    }

    #[inline]
    fn set_block<const K: usize, const M: usize>(
        &mut self,
        row: usize,
        column: usize,
        block: &[[f32; M]; K],
    ) {
        // The block is within the matrix, so `start` is below the number of elements.
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

/// Consecutive rows, up to the columns of their body, and the matrix above them.
struct Rows<'a, const K: usize> {
    above: &'a mut [f32],
    size: usize,
    /// Index of the first row.
    first: usize,
    columns: [&'a mut [f32]; K],
}

impl<const K: usize> Rows<'_, K> {
    /// Sets the rows. `moments` and `forces` accelerate the body along each of its dofs, in root axes. The moments
    /// are about the body's origin.
    #[inline]
    fn set(
        mut self,
        mut moments: [Vec3; K],
        forces: [Vec3; K],
        body: &CompositeBody,
        inner: &[CompositeBody],
    ) {
        let (mut arm_m, mut next) = (body.arm_m, body.parent);
        while let Some(this) = next.and_then(|index| inner.get(index)) {
            for (moment, force) in moments.iter_mut().zip(forces) {
                *moment += arm_m.cross(force);
            }
            // Evaluated lazily: joints with one dof do not need these loads.
            let axes = || {
                let Mat3 { x_axis, y_axis, z_axis } = this.rotation;
                [x_axis, y_axis, z_axis]
            };
            match this.joint {
                JointKind::Fixed => {}
                JointKind::Revolute { axis } => self.set_along(this.first, [axis], &moments),
                JointKind::Prismatic { axis } => self.set_along(this.first, [axis], &forces),
                JointKind::Universal { first, second } => {
                    self.set_along(this.first, [first, second], &moments);
                }
                JointKind::Spherical if this.parent.is_some() => {
                    self.set_along(this.first, axes(), &moments);
                }
                JointKind::Spherical => self.set_block(this.first, moments.map(Vec3::into)),
                JointKind::Free if this.parent.is_some() => {
                    self.set_along(this.first, axes(), &moments);
                    self.set_along(this.first.wrapping_add(3), axes(), &forces);
                }
                JointKind::Free => {
                    self.set_block(this.first, moments.map(Vec3::into));
                    self.set_block(this.first.wrapping_add(3), forces.map(Vec3::into));
                }
            }
            (arm_m, next) = (this.arm_m, this.parent);
        }
    }

    /// Sets the components of vectors along axes.
    #[inline]
    fn set_along<const M: usize>(&mut self, column: usize, axes: [Vec3; M], vectors: &[Vec3; K]) {
        self.set_block(column, vectors.map(|vector| axes.map(|axis| axis.dot(vector))));
    }

    /// Sets a block and its mirror image.
    #[inline]
    fn set_block<const M: usize>(&mut self, column: usize, block: [[f32; M]; K]) {
        for (row, numbers) in self.columns.iter_mut().zip(&block) {
            let place = row.get_mut(column..).and_then(|rest| rest.first_chunk_mut());
            if let Some(place) = place {
                *place = *numbers;
            }
        }
        // The block is within the matrix, so `start` is below the number of elements.
        let mut start = column.wrapping_mul(self.size).wrapping_add(self.first);
        for numbers in transposed(&block) {
            let place = self.above.get_mut(start..).and_then(|rest| rest.first_chunk_mut());
            if let Some(place) = place {
                *place = numbers;
            }
            start = start.wrapping_add(self.size);
        }
    }
}

#[inline]
fn transposed<const K: usize, const M: usize>(block: &[[f32; M]; K]) -> [[f32; K]; M] {
    let mut mirror = [[0.0; K]; M];
    for (k, numbers) in block.iter().enumerate() {
        for (row, number) in mirror.iter_mut().zip(numbers) {
            if let Some(slot) = row.get_mut(k) {
                *slot = *number;
            }
        }
    }
    mirror
}
