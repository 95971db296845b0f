//! Forward kinematics: world states from joint states.

use crate::math;
use crate::state::{BodyState, JointState};
use crate::transform::Twist;
use crate::tree::Body;

/// Computes the world states of all bodies. O(n).
///
/// `joints` and `out` are by body. Items beyond the shortest of the three slices are unchanged.
///
/// ```
/// use sinew_core::{kinematics, Body, BodyState, Inertia, JointKind, JointStates, Transform, Tree, glam::Vec3};
/// let link = |parent, x| Body {
///     parent,
///     joint: JointKind::Spherical,
///     placement: Transform::from_translation(Vec3::new(x, 0.0, 0.0)),
///     inertia: Inertia::default(),
///     rotor_inertia: 0.0,
/// };
/// let arm = Tree::<2>::from_bodies(&[link(None, 1.0), link(Some(0), 0.5)])?;
/// let mut world = [BodyState::WORLD; 2];
/// kinematics::body_states(arm.bodies(), JointStates::rest(&arm).as_slice(), &mut world);
/// assert_eq!(world[1].pose.translation_m, Vec3::new(1.5, 0.0, 0.0));
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn body_states(bodies: &[Body], joints: &[JointState], out: &mut [BodyState]) {
    for (index, (body, joint)) in bodies.iter().zip(joints).enumerate() {
        let state = of_parent(body, out, &BodyState::WORLD).child(joint);
        let Some(slot) = out.get_mut(index) else { return };
        *slot = state;
    }
}

/// Computes world states like [`body_states`], equal to the bit, but for bodies with a parent only the rotation and
/// the angular velocity: enough for the world errors of joints that rotate. The other fields are unchanged. O(n).
pub(crate) fn body_turns(bodies: &[Body], joints: &[JointState], out: &mut [BodyState]) {
    for (index, (body, joint)) in bodies.iter().zip(joints).enumerate() {
        let parent = body.parent.and_then(|parent| out.get(parent));
        let Some(BodyState { pose, velocity }) = parent else {
            let Some(slot) = out.get_mut(index) else { return };
            let velocity = joint.velocity.rotated(joint.pose.rotation);
            *slot = BodyState { pose: joint.pose, velocity };
            continue;
        };
        let rotation = pose.rotation * joint.pose.rotation;
        let angular = velocity.angular + math::rotate(rotation, joint.velocity.angular);
        let Some(slot) = out.get_mut(index) else { return };
        (slot.pose.rotation, slot.velocity.angular) = (rotation, angular);
    }
}

/// Computes joint states from world states: the inverse of [`body_states`], eq. (5) of Notman et al. (2011). O(n).
///
/// ```
/// use sinew_core::{Body, BodyState, Inertia, JointKind, JointState, JointStates, Transform, Tree};
/// use sinew_core::{glam::Vec3, kinematics};
/// # let link = |parent, x| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::from_translation(Vec3::new(x, 0.0, 0.0)),
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let arm = Tree::<2>::from_bodies(&[link(None, 1.0), link(Some(0), 0.5)])?;
/// let joints = JointStates::rest(&arm);
/// let mut world = [BodyState::WORLD; 2];
/// kinematics::body_states(arm.bodies(), joints.as_slice(), &mut world);
/// let mut back = [JointState::default(); 2];
/// kinematics::joint_states(arm.bodies(), &world, &mut back);
/// assert_eq!(back, joints.as_slice());
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn joint_states(bodies: &[Body], world: &[BodyState], out: &mut [JointState]) {
    for ((body, state), slot) in bodies.iter().zip(world).zip(out) {
        *slot = state.joint_state(of_parent(body, world, &BodyState::WORLD));
    }
}

/// Computes the world accelerations of all bodies: angular, and of the origin (classical). O(n).
///
/// `world` are the states from [`body_states`]. `accelerations` are those of the joints, relative to the parent, in
/// body axes, as in [`inverse_dynamics`](crate::dynamics::inverse_dynamics).
///
/// ```
/// use sinew_core::{kinematics, Body, BodyState, Inertia, JointKind, JointStates, Twist, Transform, Tree, glam::Vec3};
/// # let link = |parent, x| Body {
/// #     parent,
/// #     joint: JointKind::Spherical,
/// #     placement: Transform::from_translation(Vec3::new(x, 0.0, 0.0)),
/// #     inertia: Inertia::default(),
/// #     rotor_inertia: 0.0,
/// # };
/// let arm = Tree::<2>::from_bodies(&[link(None, 0.0), link(Some(0), 0.5)])?;
/// let mut joints = JointStates::rest(&arm);
/// let mut shoulder = joints.as_slice()[0];
/// shoulder.velocity.angular = Vec3::Z * 2.0;
/// joints.set(0, shoulder).expect("it is finite");
/// let mut world = [BodyState::WORLD; 2];
/// kinematics::body_states(arm.bodies(), joints.as_slice(), &mut world);
/// let mut accelerations = [Twist::ZERO; 2];
/// kinematics::body_accelerations(arm.bodies(), &world, &[Twist::ZERO; 2], &mut accelerations);
/// // In a steady rotation, the elbow accelerates inwards: (2 rad/s)² 0.5 m.
/// assert_eq!(accelerations[1].linear, Vec3::X * -2.0);
/// // The inverse: no joint accelerates.
/// kinematics::joint_accelerations(arm.bodies(), &world, &mut accelerations);
/// assert_eq!(accelerations, [Twist::ZERO; 2]);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn body_accelerations(
    bodies: &[Body],
    world: &[BodyState],
    accelerations: &[Twist],
    out: &mut [Twist],
) {
    for (index, ((body, state), acceleration)) in
        bodies.iter().zip(world).zip(accelerations).enumerate()
    {
        let parent = of_parent(body, world, &BodyState::WORLD);
        let carried = carried(*of_parent(body, out, &Twist::ZERO), parent, state);
        let moving = velocity_products(parent, state);
        let Some(slot) = out.get_mut(index) else { return };
        *slot = carried + moving + acceleration.rotated(state.pose.rotation);
    }
}

/// Replaces world accelerations by joint accelerations, in place: the inverse of [`body_accelerations`]. O(n).
pub fn joint_accelerations(bodies: &[Body], world: &[BodyState], accelerations: &mut [Twist]) {
    // From the leaves inwards: the parent's value is then still its world acceleration.
    for (index, (body, state)) in bodies.iter().zip(world).enumerate().rev() {
        let parent = of_parent(body, world, &BodyState::WORLD);
        let carried = carried(*of_parent(body, accelerations, &Twist::ZERO), parent, state);
        let moving = velocity_products(parent, state);
        let Some(slot) = accelerations.get_mut(index) else { continue };
        *slot = (*slot - (carried + moving)).rotated(state.pose.rotation.conjugate());
    }
}

/// Returns the part of a body's acceleration due to its parent's, as if both were one rigid body at rest, in world
/// axes.
pub(crate) fn carried(of_parent: Twist, parent: &BodyState, body: &BodyState) -> Twist {
    let arm = body.pose.translation_m - parent.pose.translation_m;
    Twist { linear: of_parent.linear + of_parent.angular.cross(arm), ..of_parent }
}

/// Returns the part of a body's acceleration due to velocities: centripetal and Coriolis, in world axes.
///
/// `ω × (ω × l) + 2 ω × v_rel`, with `v_rel` the difference of the velocities minus `ω × l`.
pub(crate) fn velocity_products(parent: &BodyState, body: &BodyState) -> Twist {
    let arm = body.pose.translation_m - parent.pose.translation_m;
    let (of_parent, of_body) = (parent.velocity, body.velocity);
    let apart = (of_body.linear - of_parent.linear) * 2.0;
    Twist {
        angular: of_parent.angular.cross(of_body.angular),
        linear: of_parent.angular.cross(apart - of_parent.angular.cross(arm)),
    }
}

/// Returns the item of a body's parent in a slice by body; `world` for the root.
#[inline]
pub(crate) fn of_parent<'a, T>(body: &Body, items: &'a [T], world: &'a T) -> &'a T {
    body.parent.and_then(|parent| items.get(parent)).unwrap_or(world)
}
