//! What inertia the drive of a joint feels.

use glam::{Mat3, Vec3};
use heapless::Vec;

use crate::inertia::{Inertia, RotationalInertia};
use crate::state::{JointState, JointStates};
use crate::transform::{Motion, Wrench};
use crate::tree::Tree;

/// What the joints beyond a joint do while it is accelerated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OuterJoints {
    /// They are held: the joint moves its subtree as one body. The composite-rigid-body inertia, the
    /// diagonal blocks of the mass matrix.
    Locked,
    /// They give way: the articulated-body inertia (Featherstone, *Rigid Body Dynamics Algorithms*, 2008,
    /// ch. 7), never more than with locked joints. What a torque meets before any other drive has reacted.
    Free,
}

/// Inertia against which a joint's drive works while the parent is held, along the joint's freedoms; zero
/// across them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReflectedInertia {
    /// Moment per angular acceleration, about the joint, body axes.
    pub angular_kg_m2: RotationalInertia,
    /// Force per linear acceleration, the mean of the ways that the joint slides.
    pub linear_kg: f32,
}

impl ReflectedInertia {
    /// Moment and force for an acceleration in body axes.
    pub fn wrench(&self, acceleration: Motion) -> Wrench {
        Wrench {
            moment_nm: self.angular_kg_m2.mul_vec3(acceleration.angular),
            force_n: acceleration.linear * self.linear_kg,
        }
    }
}

/// The reflected inertia of every joint in one pose. O(n), for settings: it is constant in no other pose.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointStates, RotationalInertia, Transform, Tree};
/// use sinew_core::dynamics::{OuterJoints, reflected_inertia};
/// use sinew_core::glam::Vec3;
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
/// };
/// let tree = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.5)])?;
/// let rest = JointStates::rest(&tree);
/// let of = |outer| reflected_inertia(&tree, &rest, outer)[0].angular_kg_m2.zz;
/// assert!((of(OuterJoints::Locked) - (0.25 + 1.0)).abs() < 1e-6);
/// // Along the line the outer weight swings out of the way of any turn of the inner arm.
/// assert!((of(OuterJoints::Free) - 0.25).abs() < 1e-6);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn reflected_inertia<const N: usize>(
    tree: &Tree<N>,
    pose: &JointStates<N>,
    outer: OuterJoints,
) -> Vec<ReflectedInertia, N> {
    let bodies = tree.bodies();
    let mut inertias: Vec<SpatialInertia, N> =
        bodies.iter().map(|body| SpatialInertia::of(&body.inertia)).collect();
    let mut reflected: Vec<ReflectedInertia, N> =
        bodies.iter().map(|_| ReflectedInertia::default()).collect();
    // Inward: a body is done when all beyond it have been added.
    for (index, (body, joint)) in bodies.iter().zip(pose.as_slice()).enumerate().rev() {
        let Some(mut inertia) = inertias.get(index).copied() else { continue };
        let in_joint = body.placement.rotation.conjugate() * joint.pose.rotation;
        let freedoms = body.joint.motion_subspace(in_joint);
        if let Some(slot) = reflected.get_mut(index) {
            *slot = inertia.along(&freedoms);
        }
        if outer == OuterJoints::Free {
            inertia = inertia.without(&freedoms);
        }
        if let Some(parent) = body.parent.and_then(|parent| inertias.get_mut(parent)) {
            *parent = parent.plus(&inertia.seen_from_parent(joint));
        }
    }
    reflected
}

/// Wrench per acceleration of a body, both at its origin and in body axes: a symmetric 6 x 6 matrix.
#[derive(Debug, Clone, Copy)]
struct SpatialInertia {
    /// Moment per angular acceleration.
    angular: Mat3,
    /// Moment per linear acceleration; its transpose is force per angular acceleration.
    coupling: Mat3,
    /// Force per linear acceleration.
    linear: Mat3,
}

impl SpatialInertia {
    fn of(inertia: &Inertia) -> Self {
        let i = &inertia.rotational_kg_m2;
        let about_center = Mat3::from_cols(
            Vec3::new(i.xx, i.xy, i.xz),
            Vec3::new(i.xy, i.yy, i.yz),
            Vec3::new(i.xz, i.yz, i.zz),
        );
        let arm = cross_matrix(inertia.center_of_mass_m);
        let coupling = arm * inertia.mass_kg;
        Self {
            angular: about_center - coupling * arm,
            coupling,
            linear: Mat3::from_diagonal(Vec3::splat(inertia.mass_kg)),
        }
    }

    fn wrench(&self, acceleration: Motion) -> Wrench {
        Wrench {
            moment_nm: self.angular * acceleration.angular + self.coupling * acceleration.linear,
            force_n: self.coupling.transpose() * acceleration.angular
                + self.linear * acceleration.linear,
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            angular: self.angular + other.angular,
            coupling: self.coupling + other.coupling,
            linear: self.linear + other.linear,
        }
    }

    /// What it is along a joint's freedoms.
    fn along(&self, freedoms: &[Motion]) -> ReflectedInertia {
        let mut onto = Mat3::ZERO;
        let (mut mass, mut ways) = (0.0, 0.0);
        for freedom in freedoms {
            onto += outer(freedom.angular, freedom.angular);
            mass += freedom.linear.dot(self.linear * freedom.linear);
            ways += freedom.linear.dot(freedom.linear);
        }
        let m = onto * self.angular * onto;
        ReflectedInertia {
            angular_kg_m2: RotationalInertia {
                xx: m.x_axis.x,
                xy: m.x_axis.y,
                xz: m.x_axis.z,
                yy: m.y_axis.y,
                yz: m.y_axis.z,
                zz: m.z_axis.z,
            },
            linear_kg: if ways > 0.0 { mass / ways } else { 0.0 },
        }
    }

    /// What is left of it if a joint gives way along its freedoms: one after the other is eliminated.
    fn without(mut self, freedoms: &[Motion]) -> Self {
        let whole = self;
        for freedom in freedoms {
            let wrench = self.wrench(*freedom);
            let resistance = wrench.power_w(*freedom);
            // What the freedoms before have taken away but for rounding has no direction left.
            if resistance > ROUNDING * whole.wrench(*freedom).power_w(*freedom) {
                let share = 1.0 / resistance;
                self.angular -= outer(wrench.moment_nm, wrench.moment_nm) * share;
                self.coupling -= outer(wrench.moment_nm, wrench.force_n) * share;
                self.linear -= outer(wrench.force_n, wrench.force_n) * share;
            }
        }
        self
    }

    /// At the parent's origin, in the parent's axes.
    fn seen_from_parent(&self, joint: &JointState) -> Self {
        let turn = Mat3::from_quat(joint.pose.rotation);
        let turned = |m: Mat3| turn * m * turn.transpose();
        let arm = cross_matrix(joint.pose.translation_m);
        let (coupling, linear) = (turned(self.coupling), turned(self.linear));
        let moved = coupling + arm * linear;
        Self {
            angular: turned(self.angular) + arm * coupling.transpose() - moved * arm,
            coupling: moved,
            linear,
        }
    }
}

/// Share of an inertia that is rounding, after a few differences.
const ROUNDING: f32 = 1e-6;

/// The matrix of `v ×`.
fn cross_matrix(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// `a bᵀ`.
fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}
