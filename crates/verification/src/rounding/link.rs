//! Bodies of a rig, with rounding.

use sinew_core::{Body, JointKind};

use super::motion::Motion;
use super::number::Number;
use super::space::{Matrix, Rotation, Vector};
use super::states::Joint;

/// A body of a rig and its joint.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Index of the parent; `None` for the world.
    pub parent: Option<usize>,
    /// Kind of the joint.
    pub joint: JointKind,
    /// Mass, kg.
    pub mass: Number,
    /// Centre of mass, m.
    pub center: Vector,
    /// Inertia about the centre of mass, kg m².
    pub inertia: Matrix,
    /// Rotor inertia of the joint's drive.
    pub rotor: Number,
    /// Rotation of the joint's placement.
    pub placement: Rotation,
}

impl Link {
    /// Creates a body from the core's, whose f32 numbers are exact.
    pub fn known(body: &Body) -> Self {
        let i = &body.inertia.rotational_kg_m2;
        let inertia = [i.xx, i.xy, i.xz, i.yy, i.yz, i.zz];
        let number = |x: f32| Number::known(f64::from(x));
        Self {
            parent: body.parent,
            joint: body.joint,
            mass: number(body.inertia.mass_kg),
            center: Vector::known(body.inertia.center_of_mass_m),
            inertia: symmetric(inertia.map(number)),
            rotor: number(body.rotor_inertia),
            placement: Rotation::known(body.placement.rotation),
        }
    }

    /// Returns the columns of the motion subspace, angular and linear, like
    /// [`JointKind::motion_subspace`](sinew_core::JointKind::motion_subspace): the first axis of a universal joint
    /// is rotated back by the rotation in the joint.
    pub fn columns(&self, joint: &Joint) -> Vec<Motion> {
        let in_joint = self.placement.inverse().after(joint.rotation);
        self.columns_by(|first| in_joint.inverse().turn(first))
    }

    /// Returns the columns like [`Self::columns`], but rotates the first axis of a universal joint by way of the
    /// parent's axes, as the mass matrix and forward dynamics do. Errors in the lengths of two quaternions cancel in
    /// the product of the quaternions, but not in this computation.
    pub fn columns_by_parent(&self, to_parent: &Matrix) -> Vec<Motion> {
        self.columns_by(|first| to_parent.turn_back(self.placement.turn(first)))
    }

    fn columns_by(&self, turned: impl Fn(Vector) -> Vector) -> Vec<Motion> {
        let columns = self.joint.motion_subspace(sinew_core::glam::Quat::IDENTITY);
        let mut columns: Vec<_> = columns
            .iter()
            .map(|column| Motion {
                angular: Vector::known(column.angular),
                linear: Vector::known(column.linear),
            })
            .collect();
        // The first axis of a universal joint is fixed in the joint frame, all other axes in the body.
        if let (JointKind::Universal { first, .. }, Some(column)) =
            (self.joint, columns.first_mut())
        {
            column.angular = turned(Vector::known(first));
        }
        columns
    }
}

/// Creates a symmetric matrix from its elements xx, xy, xz, yy, yz, zz.
pub fn symmetric([xx, xy, xz, yy, yz, zz]: [Number; 6]) -> Matrix {
    let column = |x, y, z| Vector { x, y, z };
    Matrix::of_columns([column(xx, xy, xz), column(xy, yy, yz), column(xz, yz, zz)])
}
