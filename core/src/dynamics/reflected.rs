//! The inertia that a joint's drive works against.

use glam::Mat3;
use heapless::Vec;

use super::articulated_inertia::ArticulatedInertia;
use super::rigid_inertia::RigidInertia;
use crate::fixed;
use crate::inertia::RotationalInertia;
use crate::joint_states::JointStates;
use crate::symmetric::{ROUNDING, Symmetric};
use crate::transform::{Twist, Wrench};
use crate::tree::Tree;

/// The behaviour of the joints beyond a joint while that joint accelerates.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(rename_all = "snake_case")
)]
pub enum OuterJoints {
    /// The outer joints are held: the joint moves its subtree as one body. This gives the composite-rigid-body
    /// inertia, the diagonal blocks of the mass matrix.
    Locked,
    /// The outer joints yield. This gives the articulated-body inertia (Featherstone, *Rigid Body Dynamics
    /// Algorithms*, 2008, ch. 7), never larger than with locked joints. It is the resistance before any other drive
    /// has reacted.
    Free,
}

/// The inertia that a joint's drive works against while the parent is held, along the joint's dofs; zero across them.
/// It includes the drive's own rotor.
///
/// ```
/// use sinew_core::{Twist, RotationalInertia, dynamics::ReflectedInertia, glam::Vec3};
/// let of_joint = ReflectedInertia {
///     angular_kg_m2: RotationalInertia::diagonal(0.0, 0.0, 0.25),
///     linear_kg: 0.0,
/// };
/// // A hinge about z: 4 rad/s² need 1 N m.
/// let wrench = of_joint.wrench(Twist::new(Vec3::Z * 4.0, Vec3::ZERO));
/// assert_eq!(wrench.moment_nm, Vec3::Z);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(deny_unknown_fields)
)]
pub struct ReflectedInertia {
    /// Moment per angular acceleration, about the joint, in body axes, kg m².
    pub angular_kg_m2: RotationalInertia,
    /// Force per linear acceleration, the mean over the directions in which the joint slides, kg.
    #[cfg_attr(feature = "serde", serde(deserialize_with = "crate::read::finite"))]
    pub linear_kg: f32,
}

impl ReflectedInertia {
    /// Returns `true` if every component is finite. Masses and lengths near the limit of f32 give `false`.
    pub fn is_finite(&self) -> bool {
        self.angular_kg_m2.is_finite() && self.linear_kg.is_finite()
    }

    /// Returns moment and force for an acceleration in body axes.
    pub fn wrench(&self, acceleration: Twist) -> Wrench {
        Wrench {
            moment_nm: self.angular_kg_m2.mul_vec3(acceleration.angular),
            force_n: acceleration.linear * self.linear_kg,
        }
    }
}

/// Computes the reflected inertia of every joint in one pose. O(n). Use the result for settings only, because the
/// inertia differs in other poses.
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
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.5)])?;
/// let rest = JointStates::rest(&tree);
/// let of = |outer| reflected_inertia(&tree, &rest, outer)[0].angular_kg_m2.zz;
/// assert!((of(OuterJoints::Locked) - (0.25 + 1.0)).abs() < 1e-6);
/// // In line with the inner arm, the outer weight yields to any rotation of the inner arm.
/// assert!((of(OuterJoints::Free) - 0.25).abs() < 1e-6);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn reflected_inertia<const N: usize>(
    tree: &Tree<N>,
    pose: &JointStates<N>,
    outer: OuterJoints,
) -> Vec<ReflectedInertia, N> {
    let bodies = tree.bodies();
    let of_body = |inertia| ArticulatedInertia::from(&RigidInertia::of(inertia));
    let mut inertias: Vec<ArticulatedInertia, N> =
        fixed::collect(bodies.iter().map(|body| of_body(&body.inertia)));
    let mut reflected: Vec<ReflectedInertia, N> =
        fixed::collect(bodies.iter().map(|_| ReflectedInertia::default()));
    // Inward: a body is complete when all bodies beyond it have been added.
    for (index, (body, joint)) in bodies.iter().zip(pose.as_slice()).enumerate().rev() {
        let Some(mut inertia) = inertias.get(index).copied() else { continue };
        let in_joint = body.placement.rotation.conjugate() * joint.pose.rotation;
        let dofs = body.joint.motion_subspace(in_joint);
        if let Some(slot) = reflected.get_mut(index) {
            *slot = along(&inertia, &dofs, body.rotor_inertia);
        }
        if outer == OuterJoints::Free {
            give_way(&mut inertia, &dofs, body.rotor_inertia);
        }
        if let Some(parent) = body.parent.and_then(|parent| inertias.get_mut(parent)) {
            parent.add(&inertia, &Mat3::from_quat(joint.pose.rotation), joint.pose.translation_m);
        }
    }
    reflected
}

/// Returns an inertia along a joint's dofs, with a rotor on each.
fn along(inertia: &ArticulatedInertia, dofs: &[Twist], rotor: f32) -> ReflectedInertia {
    let mut onto = Symmetric::ZERO;
    let (mut mass, mut ways) = (0.0, 0.0);
    for dof in dofs {
        onto += Symmetric::from_outer(dof.angular, dof.angular * 0.5);
        let way = dof.linear.dot(dof.linear);
        mass += dof.linear.dot(inertia.linear * dof.linear) + rotor * way;
        ways += way;
    }
    let angular = inertia.angular.turned(&onto.to_mat3()) + onto * rotor;
    ReflectedInertia {
        angular_kg_m2: RotationalInertia::from(&angular),
        linear_kg: if ways > 0.0 { mass / ways } else { 0.0 },
    }
}

/// Eliminates a joint's dofs from an inertia, one after the other, each against a rotor.
fn give_way(inertia: &mut ArticulatedInertia, dofs: &[Twist], rotor: f32) {
    let whole = *inertia;
    for dof in dofs {
        let wrench = wrench_of(inertia, *dof);
        let resistance = wrench.power_w(*dof) + rotor;
        // If only rounding is left, earlier dofs have already eliminated this direction.
        if resistance > ROUNDING * wrench_of(&whole, *dof).power_w(*dof) {
            inertia.give_way(&wrench, 1.0 / resistance);
        }
    }
}

/// Calls [`ArticulatedInertia::wrench`] without inlining: the tick does not use it, and one copy saves flash.
#[inline(never)]
fn wrench_of(inertia: &ArticulatedInertia, acceleration: Twist) -> Wrench {
    inertia.wrench(acceleration)
}
