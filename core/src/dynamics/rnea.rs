//! The recursive Newton-Euler algorithm: inverse dynamics.

use glam::{Mat3, Vec3};

use crate::kinematics::of_parent;
use crate::math::plus_cross;
use crate::state::JointState;
use crate::transform::{Twist, Wrench};
use crate::tree::Body;

/// Absolute velocity and acceleration of a body in its own axes: scratch memory of [`inverse_dynamics`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BodyMotion {
    angular_velocity: Vec3,
    angular_acceleration: Vec3,
    /// Acceleration of the body's origin, classical, minus gravity. Gravity then needs no further computation.
    linear_acceleration: Vec3,
}

impl BodyMotion {
    const AT_REST: Self = Self {
        angular_velocity: Vec3::ZERO,
        angular_acceleration: Vec3::ZERO,
        linear_acceleration: Vec3::ZERO,
    };
}

/// Computes the wrench that each joint must transmit to its body for the given motion: the recursive Newton-Euler
/// algorithm in the vector form of Luh, Walker & Paul, "On-Line Computational Scheme for Mechanical Manipulators"
/// (1980), for joints of any kind and a fixed or a free root. O(n).
///
/// - `joints`: states relative to the parent, in body axes. The linear velocity and acceleration of joints that do
///   not slide are not read.
/// - `accelerations`: of each joint, relative to the parent, in body axes: the derivative of the components of the
///   angular velocity, and the second derivative of the position, turned to body axes.
/// - `gravity_m_s2`: in world axes.
/// - `external`: wrench on each body from outside, about its origin, in body axes; may be shorter than the tree, or
///   empty.
/// - `scratch`: contents do not matter.
/// - `out`: wrench of joint i on body i about the origin of body i, in body axes. A joint's drive must deliver the
///   part along the motion subspace, which includes the rotor ([`Body::rotor_inertia`]). The power of joint i is
///   `out[i] · velocity[i]`. The items are wrenches, or contain a wrench, such as
///   [`Limited`](crate::control::Limited).
///
/// If a slice is shorter than the tree, the bodies beyond it are left out.
///
/// For a free root, `out[0]` is the wrench that must act from outside for the given motion of the root: zero for a
/// figure that flies freely.
///
/// ```
/// use sinew_core::{Body, Inertia, JointKind, JointStates, Twist, RotationalInertia, Transform, Tree, Wrench};
/// use sinew_core::{dynamics::{BodyMotion, inverse_dynamics}, glam::Vec3};
/// // A 2 kg weight on a 0.5 m arm held level against gravity: 2 * 9.81 * 0.5 = 9.81 N m.
/// let arm = Body {
///     parent: None,
///     joint: JointKind::Revolute { axis: Vec3::Z },
///     placement: Transform::IDENTITY,
///     inertia: Inertia {
///         mass_kg: 2.0,
///         center_of_mass_m: Vec3::new(0.5, 0.0, 0.0),
///         rotational_kg_m2: RotationalInertia::default(),
///     },
///     rotor_inertia: 0.0,
/// };
/// let tree = Tree::<1>::from_bodies(&[arm])?;
/// let joints = JointStates::rest(&tree);
/// let (mut scratch, mut out) = ([BodyMotion::default()], [Wrench::ZERO]);
/// let gravity = Vec3::new(0.0, -9.81, 0.0);
/// inverse_dynamics(tree.bodies(), joints.as_slice(), &[Twist::ZERO], gravity, &[], &mut scratch, &mut out);
/// assert!((out[0].moment_nm.z - 9.81).abs() < 1e-5);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn inverse_dynamics<W: AsRef<Wrench> + AsMut<Wrench>>(
    bodies: &[Body],
    joints: &[JointState],
    accelerations: &[Twist],
    gravity_m_s2: Vec3,
    external: &[Wrench],
    scratch: &mut [BodyMotion],
    out: &mut [W],
) {
    // A body that is missing from one slice is not part of the tree.
    let count = [joints.len(), accelerations.len(), scratch.len(), out.len()]
        .into_iter()
        .fold(bodies.len(), usize::min);
    let bodies = bodies.get(..count).unwrap_or_default();

    // Outward: motions from the root to the leaves.
    for (index, ((body, joint), acceleration)) in
        bodies.iter().zip(joints).zip(accelerations).enumerate()
    {
        let parent = *of_parent(body, scratch, &BodyMotion::AT_REST);
        let Some(slot) = scratch.get_mut(index) else { return };
        *slot = outward(&parent, joint, acceleration, body.joint.slides());
        if body.parent.is_none() {
            fall(slot, joint, gravity_m_s2);
        }
    }
    // The wrench that each body needs by itself. A separate loop: merged with the loop above, x86 compilers spend
    // more time on moves between registers than on the computation.
    for (index, (body, motion)) in bodies.iter().zip(scratch.iter()).enumerate() {
        let Some(out_slot) = out.get_mut(index) else { return };
        let mut needed = newton_euler(body, motion);
        if let Some(from_outside) = external.get(index) {
            needed.moment_nm -= from_outside.moment_nm;
            needed.force_n -= from_outside.force_n;
        }
        *out_slot.as_mut() = needed;
    }

    // Inward: each joint transmits the wrench that its body and the joints beyond it need.
    for (index, (body, joint)) in bodies.iter().zip(joints).enumerate().rev() {
        let Some(of_joint) = out.get_mut(index).map(W::as_mut) else { continue };
        let wrench = *of_joint;
        // Only the joint's own wrench includes the rotor, because the parent does not feel the rotor.
        if body.rotor_inertia > 0.0 {
            add_rotor(of_joint, body, accelerations.get(index));
        }
        let Some(parent) = body.parent else { continue };
        let to_parent = Mat3::from_quat(joint.pose.rotation);
        let force_n = to_parent * wrench.force_n;
        let moment_nm = plus_cross(to_parent * wrench.moment_nm, joint.pose.translation_m, force_n);
        if let Some(of_parent) = out.get_mut(parent).map(W::as_mut) {
            *of_parent = *of_parent + Wrench { moment_nm, force_n };
        }
    }
}

/// Adds the torque that accelerates the rotor of a joint's drive: along each axis its inertia times the axis
/// acceleration. This holds for a universal joint too: the acceleration due to its moving axes is perpendicular to
/// both axes.
///
/// Never inlined, since most joints have no rotor and would lose registers.
#[inline(never)]
fn add_rotor(wrench: &mut Wrench, body: &Body, acceleration: Option<&Twist>) {
    let Some(Twist { angular, linear }) = acceleration else { return };
    wrench.moment_nm += *angular * body.rotor_inertia;
    if body.joint.slides() {
        wrench.force_n += *linear * body.rotor_inertia;
    }
}

/// Adds gravity to the motion of a root, as an upward acceleration of the world. Never inlined, because inlined
/// code would take registers from the loop over all bodies.
#[inline(never)]
fn fall(motion: &mut BodyMotion, joint: &JointState, gravity_m_s2: Vec3) {
    let to_body = Mat3::from_quat(joint.pose.rotation).transpose();
    motion.linear_acceleration += to_body * -gravity_m_s2;
}

/// Returns the motion of a body from the motions of its parent and its joint.
#[inline]
fn outward(
    parent: &BodyMotion,
    joint: &JointState,
    acceleration: &Twist,
    slides: bool,
) -> BodyMotion {
    let to_body = Mat3::from_quat(joint.pose.rotation).transpose();
    let arm = joint.pose.translation_m;
    let w = joint.velocity.angular;
    let carried_velocity = to_body * parent.angular_velocity;
    let turning = parent.angular_velocity.cross(arm);
    let carried_acceleration = parent.linear_acceleration
        + parent.angular_acceleration.cross(arm)
        + parent.angular_velocity.cross(turning);
    let mut linear_acceleration = to_body * carried_acceleration;
    if slides {
        let v = joint.velocity.linear;
        linear_acceleration += carried_velocity.cross(v + v) + acceleration.linear;
    }
    BodyMotion {
        angular_velocity: carried_velocity + w,
        angular_acceleration: to_body * parent.angular_acceleration
            + acceleration.angular
            + carried_velocity.cross(w),
        linear_acceleration,
    }
}

/// Returns the wrench about its origin that gives a body this motion: Newton's and Euler's laws.
#[inline]
fn newton_euler(body: &Body, motion: &BodyMotion) -> Wrench {
    let inertia = &body.inertia;
    let (w, alpha) = (motion.angular_velocity, motion.angular_acceleration);
    let to_center = inertia.center_of_mass_m;
    let turning = w.cross(to_center);
    let of_center =
        plus_cross(plus_cross(motion.linear_acceleration, alpha, to_center), w, turning);
    let force_n = of_center * inertia.mass_kg;
    let spin = inertia.rotational_kg_m2.mul_vec3(w);
    let about_center = plus_cross(inertia.rotational_kg_m2.mul_vec3(alpha), w, spin);
    let moment_nm = plus_cross(about_center, to_center, force_n);
    Wrench { moment_nm, force_n }
}
