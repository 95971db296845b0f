//! The articulated-body algorithm: forward dynamics.

use glam::{Mat3, Quat, Vec3};

use super::articulated_inertia::{ArticulatedInertia, transposed_mul};
use super::body_axes::in_body_axes;
use super::rigid_inertia::RigidInertia;
use crate::joint::JointKind;
use crate::state::JointState;
use crate::symmetric::{ROUNDING, Symmetric};
use crate::transform::{Twist, Wrench};
use crate::tree::Body;

/// A body together with all bodies that its joints carry: workspace of [`forward_dynamics`].
///
/// All vectors are in body axes, about the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArticulatedBody {
    to_parent: Mat3,
    /// Joint with its axes in body axes.
    joint: JointKind,
    /// Absolute angular velocity.
    angular_velocity: Vec3,
    /// Absolute acceleration, minus gravity, in classical form. Before the outward pass: only the part due to
    /// velocities.
    acceleration: Twist,
    /// Articulated inertia: the joint must transmit `inertia · acceleration + wrench`. Once the joint has yielded,
    /// this acceleration excludes the joint's own acceleration.
    inertia: ArticulatedInertia,
    wrench: Wrench,
    response: Response,
}

/// The response of a joint to forces.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Response {
    /// A fixed joint: no motion.
    Rigid,
    /// Motion along one axis.
    Axis(Along),
    /// Motion along two axes.
    Axes([Along; 2]),
    /// Rotation in any direction.
    Ball(Ball),
    /// Any motion. The acceleration of the origin is `linear` plus the part `held` of the carried acceleration.
    Free { ball: Ball, linear: Vec3, held: Option<Symmetric> },
}

/// Acceleration along an axis: `alone - per_acceleration · carried`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Along {
    alone: f32,
    per_acceleration: Wrench,
}

/// Absolute angular acceleration: `turn - per_way · (acceleration of the origin)`, plus the part `held` of the
/// carried acceleration, which is due to dofs without inertia and to a rotor.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Ball {
    turn: Vec3,
    per_way: Mat3,
    held: Option<Symmetric>,
}

impl Default for ArticulatedBody {
    /// Creates an item of a workspace. Its contents do not matter.
    fn default() -> Self {
        Self {
            to_parent: Mat3::IDENTITY,
            joint: JointKind::Fixed,
            angular_velocity: Vec3::ZERO,
            acceleration: Twist::ZERO,
            inertia: ArticulatedInertia::ZERO,
            wrench: Wrench::ZERO,
            response: Response::Rigid,
        }
    }
}

/// Computes the accelerations that the given joint wrenches cause: the articulated-body algorithm (Featherstone,
/// *Rigid Body Dynamics Algorithms*, 2008, ch. 7), for joints of any kind and a fixed or a free root. O(n).
///
/// The function is the inverse of [`inverse_dynamics`](super::inverse_dynamics), with the same conventions:
/// - `joints`: states relative to the parent, body axes.
/// - `wrenches`: of joint i on body i about the origin of body i, in body axes. Only the drive's part counts, along
///   the joint's motion subspace: the bearings carry the rest.
/// - `gravity_m_s2`: in world axes.
/// - `external`: wrench on each body from outside, about its origin, in body axes; may be shorter than the tree, or
///   empty.
/// - `workspace`: contents do not matter.
/// - `out`: acceleration of each joint, relative to the parent, in body axes: the derivative of the components of the
///   angular velocity, and the second derivative of the position, turned to body axes.
///
/// If a slice is shorter than the tree, the bodies beyond it are left out, as if they did not exist.
///
/// # Dofs without inertia
/// There may be no resistance to a joint's drive (massless bodies without a rotor, a point mass on a ball joint
/// that turns about its arm), or less than a millionth of the resistance in other directions, which is within
/// rounding. The forces then determine no acceleration. The function holds this dof for the instant, as if it were
/// welded: the body keeps its speed along the dof, and the drive's force along it has no effect. For rotations of a
/// ball joint and motions of a free joint, the direction is found for any orientation.
///
/// Finite numbers give no NaN, as long as no product of them exceeds the range of f32.
///
/// ```
/// use sinew_core::dynamics::{ArticulatedBody, forward_dynamics};
/// use sinew_core::{Body, Inertia, JointKind, JointStates, Twist, RotationalInertia, Transform, Tree, Wrench};
/// use sinew_core::glam::Vec3;
/// // A 2 kg weight on a 0.5 m arm, released when level: the weight falls freely, so α is 9.81 / 0.5 rad/s².
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
/// let (mut workspace, mut out) = ([ArticulatedBody::default()], [Twist::ZERO]);
/// let gravity = Vec3::new(0.0, -9.81, 0.0);
/// let passive = [Wrench::ZERO];
/// forward_dynamics(tree.bodies(), joints.as_slice(), &passive, gravity, &[], &mut workspace, &mut out);
/// assert!((out[0].angular.z + 19.62).abs() < 1e-5);
/// # Ok::<(), sinew_core::TreeError>(())
/// ```
pub fn forward_dynamics(
    bodies: &[Body],
    joints: &[JointState],
    wrenches: &[Wrench],
    gravity_m_s2: Vec3,
    external: &[Wrench],
    workspace: &mut [ArticulatedBody],
    out: &mut [Twist],
) {
    // A body that is missing from one slice is not part of the tree.
    let count = [joints.len(), wrenches.len(), workspace.len(), out.len()]
        .into_iter()
        .fold(bodies.len(), usize::min);
    let rig = || bodies.iter().zip(joints).take(count).enumerate();

    // First outward pass: velocities, and each body by itself.
    let mut external = external.iter();
    for (index, (body, joint)) in rig() {
        let Some((inner, [this, ..])) = workspace.split_at_mut_checked(index) else { return };
        let parent = body.parent.and_then(|parent| inner.get(parent));
        let carried = parent.map_or(Vec3::ZERO, |parent| parent.angular_velocity);
        let from_outside = external.next().copied().unwrap_or(Wrench::ZERO);
        this.start(body, joint, carried, from_outside);
    }

    // Inward pass: the inertia and wrench that each joint transmits to its parent, for any motion of the parent. (A
    // loop backwards by index: reversing several zipped iterators would contain a panic.)
    for index in (0..count).rev() {
        let (Some(body), Some(joint), Some(drive), Some((inner, [this, ..]))) = (
            bodies.get(index),
            joints.get(index),
            wrenches.get(index),
            workspace.split_at_mut_checked(index),
        ) else {
            return;
        };
        this.give_way(drive, body.rotor_inertia);
        if let Some(parent) = body.parent.and_then(|parent| inner.get_mut(parent)) {
            parent.carry(this, body.rotor_inertia, joint.pose.translation_m);
        }
    }

    // Second outward pass: the accelerations.
    let world = Twist::new(Vec3::ZERO, -gravity_m_s2);
    for ((index, (body, joint)), slot) in rig().zip(out) {
        let Some((inner, [this, ..])) = workspace.split_at_mut_checked(index) else { return };
        let parent = body.parent.and_then(|parent| inner.get(parent));
        *slot = this.follow(parent.map_or(world, |parent| parent.acceleration), joint);
    }
}

impl ArticulatedBody {
    /// Initializes the articulated body with this body alone: the inertia, the wrench by Newton's and Euler's laws
    /// (both about the body's origin), and the acceleration that results from the speeds.
    #[inline]
    fn start(&mut self, body: &Body, joint: &JointState, of_parent: Vec3, external: Wrench) {
        self.to_parent = Mat3::from_quat(joint.pose.rotation);
        self.joint = in_body_axes(body, &self.to_parent);
        let arm = joint.pose.translation_m;
        let carried = transposed_mul(&self.to_parent, of_parent);
        let centripetal = of_parent.cross(of_parent.cross(arm));
        let along_axes = self.joint.bias_acceleration(Quat::IDENTITY, joint.velocity);
        self.acceleration = Twist {
            angular: carried.cross(joint.velocity.angular) + along_axes.angular,
            linear: transposed_mul(&self.to_parent, centripetal),
        };
        // Like the recursive Newton-Euler algorithm: only sliding joints have this term.
        if body.joint.slides() {
            self.acceleration.linear += carried.cross(joint.velocity.linear) * 2.0;
        }
        let w = carried + joint.velocity.angular;
        self.angular_velocity = w;
        let rigid = RigidInertia::of(&body.inertia);
        self.inertia = ArticulatedInertia::from(&rigid);
        self.wrench = Wrench {
            moment_nm: w.cross(rigid.rotational_kg_m2 * w) - external.moment_nm,
            force_n: w.cross(w.cross(rigid.first_moment_kg_m)) - external.force_n,
        };
    }

    /// Lets the joint yield to the forces, together with its drive's rotor.
    #[inline]
    fn give_way(&mut self, drive: &Wrench, rotor: f32) {
        self.response = match self.joint {
            JointKind::Fixed => Response::Rigid,
            JointKind::Revolute { axis } => Response::Axis(self.turn(axis, drive, rotor)),
            JointKind::Prismatic { axis } => Response::Axis(self.slide(axis, drive, rotor)),
            JointKind::Universal { first, second } => {
                let first = self.turn(first, drive, rotor);
                Response::Axes([first, self.turn(second, drive, rotor)])
            }
            JointKind::Spherical if rotor > 0.0 => {
                Response::Ball(self.turn_any_way_with_rotor(drive, rotor))
            }
            JointKind::Spherical => Response::Ball(self.turn_any_way(drive)),
            JointKind::Free => self.move_any_way(drive),
        };
    }

    fn turn(&mut self, axis: Vec3, drive: &Wrench, rotor: f32) -> Along {
        let wrench = self.inertia.of_turn(axis);
        let resistance = axis.dot(wrench.moment_nm) + rotor;
        let force = axis.dot(drive.moment_nm - self.wrench.moment_nm);
        self.move_along(&wrench, resistance, self.inertia.angular.trace(), force)
    }

    fn slide(&mut self, axis: Vec3, drive: &Wrench, rotor: f32) -> Along {
        let wrench = self.inertia.of_slide(axis);
        let resistance = axis.dot(wrench.force_n) + rotor;
        let force = axis.dot(drive.force_n - self.wrench.force_n);
        self.move_along(&wrench, resistance, self.inertia.linear.trace(), force)
    }

    /// Lets an axis yield to a force. `wrench` and `resistance` are wrench and force per acceleration along the
    /// axis. `in_all` is the sum of the resistance in all directions.
    #[inline]
    fn move_along(&mut self, wrench: &Wrench, resistance: f32, in_all: f32, force: f32) -> Along {
        let resists = resistance > f32::MIN_POSITIVE && resistance > ROUNDING * in_all;
        let per_force = if resists { 1.0 / resistance } else { 0.0 };
        let alone = force * per_force;
        self.inertia.give_way(wrench, per_force);
        self.wrench = self.wrench + scaled(wrench, alone);
        Along { alone, per_acceleration: scaled(wrench, per_force) }
    }

    /// Lets all rotations yield: only the resistance of the origin remains.
    #[inline]
    fn turn_any_way(&mut self, drive: &Wrench) -> Ball {
        let inverse = self.inertia.angular.inverse();
        let free = drive.moment_nm - self.wrench.moment_nm;
        let turn = inverse.mul_vec3(free);
        let per_way = inverse.mul_mat3(&self.inertia.coupling);
        let back = self.inertia.coupling.transpose();
        let held = inverse.null();
        self.inertia.linear = self.inertia.linear - Symmetric::from_product(&back, &per_way);
        self.wrench = Wrench {
            moment_nm: drive.moment_nm - held_part(held, free),
            force_n: self.wrench.force_n + back * turn,
        };
        Ball { turn, per_way, held }
    }

    /// Lets all rotations yield like [`Self::turn_any_way`], against a rotor r as well.
    ///
    /// A carried angular acceleration α makes the joint yield by `(I + r)⁻¹ I α`. The joint holds the rest,
    /// `r (I + r)⁻¹ α`, and the body resists with that share of its inertia. Never inlined, since most joints have no
    /// rotor and would lose registers.
    #[inline(never)]
    fn turn_any_way_with_rotor(&mut self, drive: &Wrench, rotor: f32) -> Ball {
        let ArticulatedInertia { angular, coupling, .. } = self.inertia;
        let free = drive.moment_nm - self.wrench.moment_nm;
        self.inertia.angular = angular + Symmetric::diagonal(rotor);
        let inverse = self.inertia.angular.inverse();
        let held = inverse.matrix() * rotor + inverse.null().unwrap_or(Symmetric::ZERO);
        let ball = self.turn_any_way(drive);
        let share = held.to_mat3();
        self.inertia.angular = Symmetric::from_product(&share, &angular.to_mat3());
        self.inertia.coupling = share * coupling;
        self.wrench.moment_nm = drive.moment_nm - held * free;
        Ball { held: Some(held), ..ball }
    }

    fn move_any_way(&mut self, drive: &Wrench) -> Response {
        let ball = self.turn_any_way(drive);
        let inverse = self.inertia.linear.inverse();
        let free = drive.force_n - self.wrench.force_n;
        let held = inverse.null();
        self.wrench.force_n = drive.force_n - held_part(held, free);
        Response::Free { ball, linear: inverse.mul_vec3(free), held }
    }

    /// Adds the inertia and wrench that a child's joint transmits, at a distance `arm_m` from this body's origin.
    /// `rotor` is the rotor inertia of the child's joint.
    #[inline]
    fn carry(&mut self, child: &Self, rotor: f32, arm_m: Vec3) {
        let mut wrench = child.wrench;
        let has_rotor = rotor > 0.0;
        match child.joint {
            JointKind::Free => {}
            JointKind::Spherical if !has_rotor => {
                wrench.force_n += child.inertia.linear * child.acceleration.linear;
                self.inertia.add_linear(&child.inertia.linear, &child.to_parent, arm_m);
            }
            _ => {
                wrench = wrench + child.inertia.wrench(child.acceleration);
                self.inertia.add(&child.inertia, &child.to_parent, arm_m);
            }
        }
        let force_n = child.to_parent * wrench.force_n;
        let moment_nm = child.to_parent * wrench.moment_nm + arm_m.cross(force_n);
        self.wrench = self.wrench + Wrench { moment_nm, force_n };
    }

    /// Moves the body with its parent and its joint. Returns the joint's acceleration.
    #[inline]
    fn follow(&mut self, parent: Twist, joint: &JointState) -> Twist {
        let at_joint = parent.linear + parent.angular.cross(joint.pose.translation_m);
        let carried = Twist {
            angular: self.acceleration.angular + transposed_mul(&self.to_parent, parent.angular),
            linear: self.acceleration.linear + transposed_mul(&self.to_parent, at_joint),
        };
        self.acceleration = match (&self.response, self.joint) {
            (Response::Axis(along), JointKind::Revolute { axis }) => along.turned(axis, carried),
            (Response::Axis(along), JointKind::Prismatic { axis }) => {
                let step = along.of(carried);
                Twist { linear: carried.linear + axis * step, ..carried }
            }
            // The axis that yielded last is solved first: its response does not depend on the other axis.
            (Response::Axes([one, two]), JointKind::Universal { first, second }) => {
                one.turned(first, two.turned(second, carried))
            }
            (Response::Ball(ball), _) => ball.turned(carried),
            (Response::Free { ball, linear, held }, _) => {
                let linear = *linear + held_part(*held, carried.linear);
                ball.turned(Twist { linear, ..carried })
            }
            _ => carried,
        };
        self.joint.bias_acceleration(Quat::IDENTITY, joint.velocity) + (self.acceleration - carried)
    }
}

impl Along {
    #[inline]
    fn of(&self, carried: Twist) -> f32 {
        self.alone - self.per_acceleration.power_w(carried)
    }

    #[inline]
    fn turned(&self, axis: Vec3, carried: Twist) -> Twist {
        Twist { angular: carried.angular + axis * self.of(carried), ..carried }
    }
}

impl Ball {
    #[inline]
    fn turned(&self, carried: Twist) -> Twist {
        let held = held_part(self.held, carried.angular);
        Twist { angular: self.turn - self.per_way * carried.linear + held, ..carried }
    }
}

#[inline]
fn held_part(held: Option<Symmetric>, v: Vec3) -> Vec3 {
    held.map_or(Vec3::ZERO, |held| held * v)
}

#[inline]
fn scaled(wrench: &Wrench, factor: f32) -> Wrench {
    Wrench { moment_nm: wrench.moment_nm * factor, force_n: wrench.force_n * factor }
}
