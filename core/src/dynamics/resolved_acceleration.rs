//! Resolved acceleration: joint accelerations that give every body its desired acceleration in the world.

use super::articulated_inertia::ArticulatedInertia;
use super::least_constraint::{Demand, MotionSubspace};
use crate::body_weight::BodyWeights;
use crate::joint::JointKind;
use crate::kinematics::{carried, of_parent, velocity_products};
use crate::state::{BodyState, JointState};
use crate::transform::Twist;
use crate::tree::Body;

/// Scratch memory of [`resolved_acceleration`] for one body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ResolvedAccelerationScratch(Demand);

impl ResolvedAccelerationScratch {
    /// Initial value, before the first use.
    pub const ZERO: Self = Self(Demand::ZERO);
}

/// Replaces the desired accelerations of the bodies by the nearest accelerations that the joints allow: they minimise
/// `Σ ρᵢ² |αᵢ - α*ᵢ|² + wᵢ |aᵢ - a*ᵢ|²`, with the rotation weights `ρᵢ` and the position weights `wᵢ`. O(n).
///
/// After Luh, Walker & Paul, "Resolved-acceleration control of mechanical manipulators" (1980), applied to all bodies
/// of a tree at once. By Gauss's principle, the result equals the accelerations of bodies with those weights as
/// inertias and the desired accelerations as free fall; the articulated-body algorithm computes them.
///
/// `joints` are the measured states of the joints, and `world` those of the bodies. `accelerations` has the angular
/// acceleration of each body, and the (classical) acceleration of its origin, in world axes. On entry these are the
/// desired accelerations, on return the resulting ones.
/// [`joint_accelerations`](crate::kinematics::joint_accelerations) converts them to joints. If a slice is shorter
/// than the tree, the bodies beyond it are left out.
///
/// ```
/// use sinew_core::{Body, BodyState, Inertia, JointKind, JointStates, Twist, Transform, Tree, kinematics};
/// use sinew_core::dynamics::{ResolvedAccelerationScratch, resolved_acceleration};
/// use sinew_core::{glam::Vec3, projection::BodyWeights};
/// let link = |parent, joint, x| Body {
///     parent,
///     joint,
///     placement: Transform::from_translation(Vec3::X * x),
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// // The hinge can follow only one of two axes; the ball joint beyond it follows the other.
/// let hinge = JointKind::Revolute { axis: Vec3::Z };
/// let arm = Tree::<2>::from_bodies(&[link(None, hinge, 0.0), link(Some(0), JointKind::Spherical, 0.5)])?;
/// let joints = JointStates::rest(&arm);
/// let mut world = [BodyState::WORLD; 2];
/// kinematics::body_states(arm.bodies(), joints.as_slice(), &mut world);
/// let wanted = Twist::new(Vec3::new(0.0, 3.0, 4.0), Vec3::ZERO);
/// let (mut accelerations, mut scratch) = ([wanted; 2], [ResolvedAccelerationScratch::ZERO; 2]);
/// let weights = BodyWeights::rotations(&arm);
/// resolved_acceleration(
///     arm.bodies(), joints.as_slice(), &world, &weights, &mut scratch, &mut accelerations,
/// );
/// assert_eq!(accelerations.map(|body| body.angular), [Vec3::Z * 4.0, wanted.angular]);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn resolved_acceleration<const N: usize>(
    bodies: &[Body],
    joints: &[JointState],
    world: &[BodyState],
    weights: &BodyWeights<N>,
    scratch: &mut [ResolvedAccelerationScratch],
    accelerations: &mut [Twist],
) {
    for ((weight, wanted), ResolvedAccelerationScratch(demand)) in
        weights.as_slice().iter().zip(accelerations.iter()).zip(scratch.iter_mut())
    {
        let inertia =
            ArticulatedInertia::round(weight.rotation_m * weight.rotation_m, weight.position);
        *demand = Demand { inertia, wrench: inertia.wrench(*wanted) };
    }

    // Inward: the desired motion of every joint, as a function of its parent's motion.
    for (index, ((body, joint), state)) in bodies.iter().zip(joints).zip(world).enumerate().rev() {
        let parent = of_parent(body, world, &BodyState::WORLD);
        let Some(ResolvedAccelerationScratch(demand)) = scratch.get_mut(index) else { continue };
        // The velocities cause a part of the acceleration; the joint must supply the rest.
        let moving = by_velocities(body, parent, state, joint);
        demand.wrench = demand.wrench - demand.inertia.wrench(moving);
        let mut passed_on = *demand;
        passed_on.eliminate(&dofs(body, joint, state), 0.0);
        if passed_on == Demand::ZERO {
            // The joint can fulfil all demands beyond it, like most joints when only rotations count.
            continue;
        }
        let arm = state.pose.translation_m - parent.pose.translation_m;
        let of_parent = body.parent.and_then(|parent| scratch.get_mut(parent));
        if let Some(ResolvedAccelerationScratch(parent)) = of_parent {
            parent.add_child(&passed_on, arm);
        }
    }

    // Outward: the motion, now that the parent's acceleration is known.
    for (index, (((body, joint), state), ResolvedAccelerationScratch(demand))) in
        bodies.iter().zip(joints).zip(world).zip(scratch.iter()).enumerate()
    {
        let parent = of_parent(body, world, &BodyState::WORLD);
        let carried = carried(*of_parent(body, accelerations, &Twist::ZERO), parent, state);
        let response = demand.response(&dofs(body, joint, state));
        let moving = by_velocities(body, parent, state, joint);
        let Some(slot) = accelerations.get_mut(index) else { return };
        *slot = response.motion(carried, |_, step| step) + moving;
    }
}

fn dofs(body: &Body, joint: &JointState, state: &BodyState) -> MotionSubspace {
    MotionSubspace::of(body, joint.pose.rotation, state.pose.rotation)
}

/// Returns the part of a body's acceleration that depends only on velocities, in world axes.
fn by_velocities(body: &Body, parent: &BodyState, state: &BodyState, joint: &JointState) -> Twist {
    let moving = velocity_products(parent, state);
    if !matches!(body.joint, JointKind::Universal { .. }) {
        return moving;
    }
    let in_joint = body.placement.rotation.conjugate() * joint.pose.rotation;
    let of_joint = body.joint.bias_acceleration(in_joint, joint.velocity);
    moving + of_joint.rotated(state.pose.rotation)
}
