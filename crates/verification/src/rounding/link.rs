//! Bodies of a rig.

use sinew_core::{Body, JointKind};

use super::motion::Motion;
use super::number::Number;
use super::space::{Matrix, Rotation, Vector};
use super::states::Joint;

/// A body of a rig.
#[derive(Debug, Clone, Copy)]
pub struct Link {
    /// Its parent; `None`: the world.
    pub parent: Option<usize>,
    /// What its joint leaves free.
    pub joint: JointKind,
    /// kg.
    pub mass: Number,
    /// Centre of mass, m.
    pub center: Vector,
    /// About the centre of mass, kg m².
    pub inertia: Matrix,
    /// Of the joint's drive.
    pub rotor: Number,
    /// Rotation of the placement of the joint.
    pub placement: Rotation,
}

impl Link {
    /// A body of the core's, as f32 has it.
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

    /// Columns of the motion subspace, angular and linear, as
    /// [`JointKind::motion_subspace`](sinew_core::JointKind::motion_subspace) has them: the first axis of a universal
    /// joint turned back by the rotation in the joint.
    pub fn columns(&self, joint: &Joint) -> Vec<Motion> {
        let in_joint = self.placement.inverse().after(joint.rotation);
        self.columns_by(|first| in_joint.inverse().turn(first))
    }

    /// The same by way of the parent's axes, as the mass matrix and forward dynamics take that axis: what two
    /// quaternions are not unit by cancels in their product, and not here.
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
        // The first axis of a universal joint is fixed in the joint frame, all others in the body.
        if let (JointKind::Universal { first, .. }, Some(column)) =
            (self.joint, columns.first_mut())
        {
            column.angular = turned(Vector::known(first));
        }
        columns
    }
}

/// A symmetric matrix by its elements xx, xy, xz, yy, yz, zz.
pub fn symmetric([xx, xy, xz, yy, yz, zz]: [Number; 6]) -> Matrix {
    let column = |x, y, z| Vector { x, y, z };
    Matrix::of_columns([column(xx, xy, xz), column(xy, yy, yz), column(xz, yz, zz)])
}
