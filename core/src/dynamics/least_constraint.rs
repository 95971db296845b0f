//! Gauss's principle of least constraint for a tree, by the sweeps of the articulated-body algorithm (Featherstone,
//! *Rigid Body Dynamics Algorithms*, 2008, ch. 7). Among all motions A that the joints allow, it finds the motion
//! that minimises `Σ ½ (A - T)ᵀ I (A - T)` over the bodies, where T is a body's desired motion and I its inertia.
//!
//! The inertias need not be those of masses: the manifold projection and the resolved acceleration use them as
//! weights of each body's desired motion. O(n), and no matrix is larger than that of a single joint.

use glam::{Mat3, Quat, Vec3};
use heapless::Vec;

use super::articulated_inertia::{ArticulatedInertia, transposed_mul};
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::symmetric::Symmetric;
use crate::transform::{Twist, Wrench};
use crate::tree::Body;

/// The cost of all bodies from a joint outwards, `½ Aᵀ I A - Aᵀ W`, to be minimised. A is the motion of the joint's
/// body. All vectors are in world axes, about the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Demand {
    pub(crate) inertia: ArticulatedInertia,
    pub(crate) wrench: Wrench,
}

/// The motions that a joint allows.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum MotionSubspace {
    /// Any rotation.
    Ball,
    /// Any motion.
    Free,
    /// Rotation about an axis: the most frequent joint in a rig of servos.
    Hinge(Hinge),
    /// Motion along some axes; none for a rigid joint.
    Axes(Vec<Axis, 3>),
}

/// Rotation about an axis through the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hinge {
    /// Unit axis, world axes.
    pub(crate) axis: Vec3,
    /// Whether the joint is at the end of its range, see [`Axis::held`].
    pub(crate) held: bool,
}

/// An axis along which a joint can move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    /// Twist of the body for a unit along the axis, in world axes.
    pub(crate) motion: Twist,
    /// Whether the joint is at the end of its range and pressed against it. The bodies closer to the root then treat
    /// it as rigid.
    pub(crate) held: bool,
}

/// The motion of a joint as a function of its parent's motion.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Response {
    /// Any rotation.
    Ball(BallResponse),
    /// The body moves with this twist, for any motion of its parent.
    Free(Twist),
    /// Rotation about the axis.
    Hinge(HingeResponse),
    /// Motion along each axis.
    Axes(Vec<AxisResponse, 3>),
}

/// The body rotates by `turn` minus `per_way` times the displacement of its origin by the parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct BallResponse {
    turn: Vec3,
    per_way: Mat3,
}

/// The step about the axis is `per_force (force - wrench · carried)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct HingeResponse {
    axis: Vec3,
    wrench: Wrench,
    force: f32,
    per_force: f32,
}

/// The step along an axis is `per_force (force - wrench · carried)`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct AxisResponse {
    motion: Twist,
    wrench: Wrench,
    force: f32,
    per_force: f32,
}

impl MotionSubspace {
    /// Returns the subspace of a joint. `relative` is the body's rotation in its parent's frame, and `world` its
    /// rotation in the world.
    pub(crate) fn of(body: &Body, relative: Quat, world: Quat) -> Self {
        match body.joint {
            JointKind::Spherical => Self::Ball,
            JointKind::Free => Self::Free,
            JointKind::Revolute { axis } => {
                Self::Hinge(Hinge { axis: math::rotate(world, axis), held: false })
            }
            kind => {
                let in_joint = body.placement.rotation.conjugate() * relative;
                let axis = |motion: &Twist| Axis { motion: motion.rotated(world), held: false };
                Self::Axes(fixed::collect(kind.motion_subspace(in_joint).iter().take(3).map(axis)))
            }
        }
    }
}

impl Demand {
    pub(crate) const ZERO: Self = Self { inertia: ArticulatedInertia::ZERO, wrench: Wrench::ZERO };

    /// Eliminates a joint's dofs: the remainder is the cost that the joint transmits to its parent.
    ///
    /// An axis without resistance does not move. `damping` is the additional resistance of each rotation or axis,
    /// relative to its own resistance (Marquardt's method). Zero gives the exact minimum.
    pub(crate) fn eliminate(&mut self, dofs: &MotionSubspace, damping: f32) -> Response {
        match dofs {
            MotionSubspace::Ball => {
                let response = self.eliminate_turn(damping);
                self.inertia =
                    ArticulatedInertia { linear: self.inertia.linear, ..ArticulatedInertia::ZERO };
                self.wrench.moment_nm = Vec3::ZERO;
                response.into()
            }
            MotionSubspace::Free => {
                let BallResponse { turn, per_way } = self.eliminate_turn(damping);
                let linear = self.inertia.linear.inverse_if_definite() * self.wrench.force_n;
                *self = Self::ZERO;
                Response::Free(Twist { angular: turn - per_way * linear, linear })
            }
            MotionSubspace::Hinge(hinge) => Response::Hinge(self.eliminate_hinge(hinge, damping)),
            MotionSubspace::Axes(axes) => Response::Axes(fixed::collect(
                axes.iter().map(|axis| self.eliminate_axis(axis, damping)),
            )),
        }
    }

    /// Returns the result of [`Self::eliminate`] without damping, when the remainder is not needed.
    pub(crate) fn response(&self, dofs: &MotionSubspace) -> Response {
        if matches!(dofs, MotionSubspace::Ball) {
            return self.turn(0.0).into();
        }
        let mut demand = *self;
        demand.eliminate(dofs, 0.0)
    }

    #[inline]
    fn turn(&self, damping: f32) -> BallResponse {
        let inverse = self.inertia.angular.inverse_if_definite() * (1.0 / (1.0 + damping));
        let ArticulatedInertia { coupling, .. } = self.inertia;
        BallResponse {
            turn: inverse * self.wrench.moment_nm,
            per_way: Mat3::from_cols(
                inverse * coupling.x_axis,
                inverse * coupling.y_axis,
                inverse * coupling.z_axis,
            ),
        }
    }

    /// Eliminates all rotations. The remainder is the resistance of the origin. The angular part of the inertia and
    /// the moment are undefined afterwards.
    #[inline]
    pub(crate) fn eliminate_turn(&mut self, damping: f32) -> BallResponse {
        let response = self.turn(damping);
        let back = self.inertia.coupling.transpose();
        self.inertia.linear =
            self.inertia.linear - Symmetric::from_product(&back, &response.per_way);
        self.wrench.force_n -= transposed_mul(&self.inertia.coupling, response.turn);
        response
    }

    fn eliminate_axis(&mut self, axis: &Axis, damping: f32) -> AxisResponse {
        let wrench = self.inertia.wrench(axis.motion);
        let per_force = yielding(wrench.power_w(axis.motion), damping);
        let force = self.wrench.power_w(axis.motion);
        if !axis.held {
            self.give_way(wrench, force, per_force);
        }
        AxisResponse { motion: axis.motion, wrench, force, per_force }
    }

    /// Eliminates a hinge like an axis, without the linear terms.
    fn eliminate_hinge(&mut self, hinge: &Hinge, damping: f32) -> HingeResponse {
        let Hinge { axis, held } = *hinge;
        let wrench = self.inertia.of_turn(axis);
        let per_force = yielding(wrench.moment_nm.dot(axis), damping);
        let force = self.wrench.moment_nm.dot(axis);
        if !held {
            self.give_way(wrench, force, per_force);
        }
        HingeResponse { axis, wrench, force, per_force }
    }

    /// Eliminates an axis. `wrench` is its wrench per acceleration, and `force` is the force that it asks for.
    fn give_way(&mut self, wrench: Wrench, force: f32, per_force: f32) {
        let share = force * per_force;
        self.inertia.give_way(&wrench, per_force);
        self.wrench = self.wrench + Wrench::new(wrench.moment_nm * -share, wrench.force_n * -share);
    }

    /// Adds the cost that a child transmits, at a distance `arm_m` from this body's origin.
    pub(crate) fn add_child(&mut self, child: &Self, arm_m: Vec3) {
        self.inertia.add_at(&child.inertia, arm_m);
        self.wrench.moment_nm += child.wrench.moment_nm;
        self.add_force(child.wrench.force_n, arm_m);
    }

    /// Adds a child like [`Self::add_child`], after [`Self::eliminate_turn`].
    #[inline]
    pub(crate) fn add_ball(&mut self, child: &Self, arm_m: Vec3) {
        self.inertia.add_linear_at(&child.inertia.linear, arm_m);
        self.add_force(child.wrench.force_n, arm_m);
    }

    #[inline]
    fn add_force(&mut self, force_n: Vec3, arm_m: Vec3) {
        self.wrench.moment_nm = math::plus_cross(self.wrench.moment_nm, arm_m, force_n);
        self.wrench.force_n += force_n;
    }
}

/// Returns the step of an axis per force along the axis.
fn yielding(resistance: f32, damping: f32) -> f32 {
    let resistance = resistance * (1.0 + damping);
    if resistance > f32::MIN_POSITIVE { 1.0 / resistance } else { 0.0 }
}

impl From<BallResponse> for Response {
    fn from(ball: BallResponse) -> Self {
        Self::Ball(ball)
    }
}

impl BallResponse {
    /// Returns the rotation of the body when the parent moves the body's origin by `way`.
    #[inline]
    pub(crate) fn turn(&self, way: Vec3) -> Vec3 {
        self.turn - self.per_way * way
    }
}

impl Response {
    /// Returns the twist of the body when its parent carries it along with `carried`. `limit(k, step)` returns the
    /// allowed part of the step along axis k.
    pub(crate) fn motion(&self, carried: Twist, mut limit: impl FnMut(usize, f32) -> f32) -> Twist {
        match self {
            Self::Ball(ball) => {
                Twist { angular: ball.turn(carried.linear), linear: carried.linear }
            }
            Self::Free(motion) => *motion,
            Self::Hinge(hinge) => {
                let HingeResponse { axis, wrench, force, per_force } = *hinge;
                let step = limit(0, (force - wrench.power_w(carried)) * per_force);
                Twist { angular: carried.angular + axis * step, ..carried }
            }
            Self::Axes(axes) => {
                let mut motion = carried;
                // The axis that was eliminated last is solved first: its step depends on no other.
                for (index, axis) in axes.iter().enumerate().rev() {
                    let step = (axis.force - axis.wrench.power_w(motion)) * axis.per_force;
                    let step = limit(index, step);
                    motion =
                        motion + Twist::new(axis.motion.angular * step, axis.motion.linear * step);
                }
                motion
            }
        }
    }
}
