//! Gauss's principle of least constraint over a tree, by the sweeps of the articulated-body algorithm
//! (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 7): of all motions that the joints allow, the
//! one that makes `Σ ½ (A - T)ᵀ I (A - T)` least, body by body with its wanted motion T and its inertia I.
//!
//! The inertias need not be those of masses: the manifold projection and the resolved acceleration weigh
//! with them how much each body's wanted motion counts. O(n), and no matrix is larger than one joint's.

use glam::{Mat3, Quat, Vec3};
use heapless::Vec;

use super::spatial_inertia::SpatialInertia;
use crate::fixed;
use crate::joint::JointKind;
use crate::math;
use crate::matrix::symmetric_inverse;
use crate::transform::{Twist, Wrench};
use crate::tree::Body;

/// What the bodies from a joint outwards want: `½ Aᵀ I A - Aᵀ W` should be least, A the motion of the
/// joint's body. World axes, about the body's origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Demand {
    pub(crate) inertia: SpatialInertia,
    pub(crate) wrench: Wrench,
}

/// How a joint gives way.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Freedoms {
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
    /// The body turns by `turn` less `per_way` times the way that its parent carries it.
    Ball { turn: Vec3, per_way: Mat3 },
    /// The body moves so.
    Free(Twist),
    /// About the axis.
    Hinge(HingeResponse),
    /// Along each axis.
    Axes(Vec<AxisResponse, 3>),
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

impl Freedoms {
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
    pub(crate) const ZERO: Self = Self { inertia: SpatialInertia::ZERO, wrench: Wrench::ZERO };

    /// Takes a joint's freedoms out: what is left is what the joint passes on to its parent.
    ///
    /// An axis that nothing resists stays where it is. `damping` is by how much of its own a turn or an axis
    /// resists more (Marquardt's): zero for the least itself.
    pub(crate) fn eliminate(&mut self, freedoms: &Freedoms, damping: f32) -> Response {
        match freedoms {
            Freedoms::Ball => {
                let (turn, per_way) = self.eliminate_turn(damping);
                Response::Ball { turn, per_way }
            }
            Freedoms::Free => {
                let (turn, per_way) = self.eliminate_turn(damping);
                let linear = symmetric_inverse(&self.inertia.linear) * self.wrench.force_n;
                *self = Self::ZERO;
                Response::Free(Twist { angular: turn - per_way * linear, linear })
            }
            Freedoms::Hinge(hinge) => Response::Hinge(self.eliminate_hinge(hinge, damping)),
            Freedoms::Axes(axes) => Response::Axes(fixed::collect(
                axes.iter().map(|axis| self.eliminate_axis(axis, damping)),
            )),
        }
    }

    /// What [`Self::eliminate`] answers without damping, where nothing has to be passed on any more.
    pub(crate) fn response(&self, freedoms: &Freedoms) -> Response {
        if matches!(freedoms, Freedoms::Ball) {
            let (turn, per_way) = self.turn(0.0);
            return Response::Ball { turn, per_way };
        }
        let mut demand = *self;
        demand.eliminate(freedoms, 0.0)
    }

    fn turn(&self, damping: f32) -> (Vec3, Mat3) {
        let inverse = symmetric_inverse(&self.inertia.angular) * (1.0 / (1.0 + damping));
        (inverse * self.wrench.moment_nm, inverse * self.inertia.coupling)
    }

    fn eliminate_turn(&mut self, damping: f32) -> (Vec3, Mat3) {
        let (turn, per_way) = self.turn(damping);
        let SpatialInertia { coupling, linear, .. } = self.inertia;
        let back = coupling.transpose();
        self.inertia = SpatialInertia { linear: linear - back * per_way, ..SpatialInertia::ZERO };
        self.wrench = Wrench::new(Vec3::ZERO, self.wrench.force_n - back * turn);
        (turn, per_way)
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
        let SpatialInertia { angular, coupling, .. } = self.inertia;
        let wrench = Wrench { moment_nm: angular * axis, force_n: coupling.transpose() * axis };
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
        self.inertia = self.inertia.without_one(wrench, per_force);
        self.wrench = self.wrench + Wrench::new(wrench.moment_nm * -share, wrench.force_n * -share);
    }

    /// Adds what a child passes on, `arm_m` away from this body's origin.
    pub(crate) fn add_child(&mut self, child: &Self, arm_m: Vec3) {
        self.inertia = self.inertia.plus(&child.inertia.moved(arm_m));
        let Wrench { moment_nm, force_n } = child.wrench;
        self.wrench = self.wrench + Wrench::new(moment_nm + arm_m.cross(force_n), force_n);
    }
}

/// How far an axis goes per force along it.
fn yielding(resistance: f32, damping: f32) -> f32 {
    let resistance = resistance * (1.0 + damping);
    if resistance > f32::MIN_POSITIVE { 1.0 / resistance } else { 0.0 }
}

impl Response {
    /// Twist of the body when its parent carries it along with `carried`; `limit` is asked what of the step
    /// along axis k may be made.
    pub(crate) fn motion(&self, carried: Twist, mut limit: impl FnMut(usize, f32) -> f32) -> Twist {
        match self {
            Self::Ball { turn, per_way } => {
                Twist { angular: *turn - *per_way * carried.linear, linear: carried.linear }
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
