//! Forward kinematics: from joint states to world states.

use crate::state::{BodyState, JointState};
use crate::tree::Body;

/// World states of all bodies. O(n).
///
/// `joints` and `out` go by body; what is longer than the shortest of the three slices is left alone.
///
/// ```
/// use sinew_core::{kinematics, Body, BodyState, Inertia, JointKind, JointStates, Transform, Tree, glam::Vec3};
/// let link = |parent, x| Body {
///     parent,
///     joint: JointKind::Spherical,
///     placement: Transform::from_translation(Vec3::new(x, 0.0, 0.0)),
///     inertia: Inertia::default(),
/// };
/// let arm = Tree::<2>::from_bodies(&[link(None, 1.0), link(Some(0), 0.5)])?;
/// let mut world = [BodyState::WORLD; 2];
/// kinematics::body_states(arm.bodies(), JointStates::rest(&arm).as_slice(), &mut world);
/// assert_eq!(world[1].pose.translation_m, Vec3::new(1.5, 0.0, 0.0));
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn body_states(bodies: &[Body], joints: &[JointState], out: &mut [BodyState]) {
    for (index, (body, joint)) in bodies.iter().zip(joints).enumerate() {
        let parent = of_parent(body, out, BodyState::WORLD);
        let Some(slot) = out.get_mut(index) else { return };
        *slot = parent.child(joint);
    }
}

/// Joint states from world states: the way back from [`body_states`], eq. (5) of Notman et al. (2011).
/// O(n).
pub fn joint_states(bodies: &[Body], world: &[BodyState], out: &mut [JointState]) {
    for ((body, state), slot) in bodies.iter().zip(world).zip(out) {
        *slot = state.joint_state(&of_parent(body, world, BodyState::WORLD));
    }
}

/// The item of a body's parent in a slice by body; `world` for the root.
pub(crate) fn of_parent<T: Copy>(body: &Body, items: &[T], world: T) -> T {
    body.parent.and_then(|parent| items.get(parent)).copied().unwrap_or(world)
}
