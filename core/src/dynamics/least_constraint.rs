//! Gauss's principle of least constraint over a tree, by the sweeps of the articulated-body algorithm
//! (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 7): of all motions that the joints allow, the
//! one that makes `Σ ½ (A - T)ᵀ I (A - T)` least, body by body with its wanted motion T and its inertia I.
//!
//! The inertias need not be those of masses: the manifold projection and the resolved acceleration weigh
//! with them how much each body's wanted motion counts. O(n), and no matrix is larger than one joint's.

use glam::{Mat3, Quat, Vec3};
use heapless::Vec;

use super::articulated_inertia::{ArticulatedInertia, transposed_mul};
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::symmetric::Symmetric;
use crate::transform::{Twist, Wrench};
use crate::tree::Body;

/// What the bodies from a joint outwards want: `½ Aᵀ I A - Aᵀ W` should be least, A the motion of the
/// joint's body. World axes, about the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Demand {
    pub(crate) inertia: ArticulatedInertia,
    pub(crate) wrench: Wrench,
}

/// How a joint gives way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum MotionSubspace {
    /// To any turn.
    Ball,
    /// To anything.
    Free,
    /// To a turn about an axis: most joints of a rig of servos.
    Hinge(Hinge),
    /// Along some axes; none if it is rigid.
    Axes(Vec<Axis, 3>),
}

/// A turn about an axis through the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Hinge {
    /// Unit axis, world axes.
    pub(crate) axis: Vec3,
    /// As [`Axis::held`].
    pub(crate) held: bool,
}

/// One way that a joint can move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Axis {
    /// Twist of the body for a unit along the axis, world axes.
    pub(crate) motion: Twist,
    /// At the end of its range, and pressed against it: the bodies farther in do not count on it.
    pub(crate) held: bool,
}

/// How the joint moves, whatever its parent does.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Response {
    /// In any turn.
    Ball(BallResponse),
    /// The body moves so.
    Free(Twist),
    /// About the axis.
    Hinge(HingeResponse),
    /// Along each axis.
    Axes(Vec<AxisResponse, 3>),
}

/// The body turns by `turn` less `per_way` times the way that its parent carries it.
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
    /// Of a joint whose body is turned by `relative` in the parent and by `world` in the world.
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

    /// Takes a joint's dofs out: what is left is what the joint passes on to its parent.
    ///
    /// An axis that nothing resists stays where it is. `damping` is by how much of its own a turn or an axis
    /// resists more (Marquardt's): zero for the least itself.
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

    /// What [`Self::eliminate`] answers without damping, where nothing has to be passed on any more.
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

    /// Takes all turns out. What is left is how the origin resists; the rest of the inertia and the moment do not
    /// count any more, whatever they are.
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

    /// As an axis, with nothing to compute of ways.
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

    /// Takes out an axis that asks for `force`, from its wrench per acceleration.
    fn give_way(&mut self, wrench: Wrench, force: f32, per_force: f32) {
        let share = force * per_force;
        self.inertia.give_way(&wrench, per_force);
        self.wrench = self.wrench + Wrench::new(wrench.moment_nm * -share, wrench.force_n * -share);
    }

    /// Adds what a child passes on, `arm_m` away from this body's origin.
    pub(crate) fn add_child(&mut self, child: &Self, arm_m: Vec3) {
        self.inertia.add_at(&child.inertia, arm_m);
        self.wrench.moment_nm += child.wrench.moment_nm;
        self.add_force(child.wrench.force_n, arm_m);
    }

    /// As [`Self::add_child`], after [`Self::eliminate_turn`].
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

/// How far an axis goes per force along it.
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
    /// Turn of the body when its parent carries its origin so far.
    #[inline]
    pub(crate) fn turn(&self, way: Vec3) -> Vec3 {
        self.turn - self.per_way * way
    }
}

impl Response {
    /// Twist of the body when its parent carries it along with `carried`; `limit` is asked what of the step
    /// along axis k may be made.
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
                // The last one eliminated is the first that nothing else stands open for.
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
