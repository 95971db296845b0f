//! A joint of a pose: its state, its motion, and its range.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use sinew_core::JointKind;
use sinew_core::projection::JointRange;

/// The state of a joint's dofs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointPosition {
    /// State of a joint without dofs.
    Fixed,
    /// Angles in rad or distance in m of a joint with one or two axes; unused values are 0.
    Along([f64; 2]),
    /// Rotation in the joint frame of a spherical joint.
    Turn(DQuat),
    /// Rotation and position in the joint frame of a free joint.
    Free(DQuat, DVec3),
}

impl JointPosition {
    /// Returns the state with quaternions normalized.
    pub(super) fn normalized(self) -> Self {
        match self {
            Self::Turn(q) => Self::Turn(q.normalize()),
            Self::Free(q, p) => Self::Free(q.normalize(), p),
            other => other,
        }
    }
}

/// A direction in which a joint can move: the motion of the body per unit of its coordinate, in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub(super) angular: DVec3,
    pub(super) linear: DVec3,
}

/// The kind of a joint, with its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Model {
    Fixed,
    Revolute(DVec3),
    Prismatic(DVec3),
    Universal(DVec3, DVec3),
    Spherical,
    Free,
}

impl From<JointKind> for Model {
    fn from(kind: JointKind) -> Self {
        let unit = |axis: sinew_core::glam::Vec3| axis.as_dvec3().normalize();
        match kind {
            JointKind::Fixed => Self::Fixed,
            JointKind::Revolute { axis } => Self::Revolute(unit(axis)),
            JointKind::Prismatic { axis } => Self::Prismatic(unit(axis)),
            JointKind::Universal { first, second } => {
                let first = unit(first);
                Self::Universal(first, second.as_dvec3().reject_from(first).normalize())
            }
            JointKind::Spherical => Self::Spherical,
            JointKind::Free => Self::Free,
        }
    }
}

impl Model {
    pub(super) fn dof_count(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute(_) | Self::Prismatic(_) => 1,
            Self::Universal(..) => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }

    /// Returns whether the state is valid for this kind of joint.
    pub(super) fn has(self, state: &JointPosition) -> bool {
        let unit = |q: &DQuat| (q.length_squared() - 1.0).abs() < 1e-3;
        match (self, state) {
            (Self::Fixed, JointPosition::Fixed) => true,
            (
                Self::Revolute(_) | Self::Prismatic(_) | Self::Universal(..),
                JointPosition::Along(along),
            ) => along.iter().all(|x| x.is_finite()),
            (Self::Spherical, JointPosition::Turn(q)) => unit(q),
            (Self::Free, JointPosition::Free(q, p)) => unit(q) && p.is_finite(),
            _ => false,
        }
    }

    /// Returns rotation and position in the joint frame.
    pub(super) fn pose(self, state: &JointPosition) -> (DQuat, DVec3) {
        match (self, *state) {
            (Self::Revolute(axis), JointPosition::Along([a, _])) => {
                (DQuat::from_axis_angle(axis, a), DVec3::ZERO)
            }
            (Self::Prismatic(axis), JointPosition::Along([a, _])) => (DQuat::IDENTITY, axis * a),
            (Self::Universal(first, second), JointPosition::Along([a, b])) => {
                (DQuat::from_axis_angle(first, a) * DQuat::from_axis_angle(second, b), DVec3::ZERO)
            }
            (_, JointPosition::Turn(q)) => (q, DVec3::ZERO),
            (_, JointPosition::Free(q, p)) => (q, p),
            _ => (DQuat::IDENTITY, DVec3::ZERO),
        }
    }

    /// Returns the directions in which a joint can move, outer axes first. `frame` is the rotation of the joint frame
    /// in the world, `body` that of the body. For a ball joint with a range, the first axis leads to the end of the
    /// range.
    pub(super) fn axes(
        self,
        state: &JointPosition,
        range: JointRange,
        frame: DQuat,
        body: DQuat,
        out: &mut Vec<Axis>,
    ) {
        let turn = |axis: DVec3| Axis { angular: axis, linear: DVec3::ZERO };
        let slide = |axis: DVec3| Axis { angular: DVec3::ZERO, linear: axis };
        let turns = |basis: [DVec3; 3]| basis.map(|axis| turn(body * axis));
        match self {
            Self::Fixed => {}
            Self::Revolute(axis) => out.push(turn(body * axis)),
            Self::Prismatic(axis) => out.push(slide(frame * axis)),
            Self::Universal(first, second) => {
                out.extend([turn(frame * first), turn(body * second)]);
            }
            Self::Spherical => out.extend(turns(basis(state, range))),
            Self::Free => {
                out.extend(turns(DVec3::AXES));
                out.extend(DVec3::AXES.map(|axis| slide(frame * axis)));
            }
        }
    }

    /// Returns the state after a step along its axes.
    pub(super) fn stepped(state: &JointPosition, range: JointRange, step: &[f64]) -> JointPosition {
        match (*state, step) {
            (JointPosition::Along([a, b]), [da]) => JointPosition::Along([a + da, b]),
            (JointPosition::Along([a, b]), [da, db]) => JointPosition::Along([a + da, b + db]),
            (JointPosition::Turn(q), [x, y, z]) => {
                let [e, f, g] = basis(state, range);
                let turn = DQuat::from_scaled_axis(e * *x + f * *y + g * *z);
                JointPosition::Turn((q * turn).normalize())
            }
            (JointPosition::Free(q, p), [x, y, z, tx, ty, tz]) => JointPosition::Free(
                (q * DQuat::from_scaled_axis(DVec3::new(*x, *y, *z))).normalize(),
                p + DVec3::new(*tx, *ty, *tz),
            ),
            _ => *state,
        }
    }

    /// Returns the state at a share `t` of the path from one state to another. The path goes the shorter way round;
    /// only the angles of a joint with a range go through the range instead.
    pub(super) fn between(
        self,
        range: JointRange,
        from: &JointPosition,
        to: &JointPosition,
        t: f64,
    ) -> JointPosition {
        let turns = matches!(self, Self::Revolute(_) | Self::Universal(..));
        let way = |from: f64, to: f64| {
            let way = to - from;
            if turns && range == JointRange::Any { way - TAU * libm::rint(way / TAU) } else { way }
        };
        let turned = |a: DQuat, b: DQuat| {
            let vector = rotation_vector(a.conjugate() * b);
            (a * DQuat::from_scaled_axis(vector * t)).normalize()
        };
        match (*from, *to) {
            (JointPosition::Along([a, b]), JointPosition::Along([c, d])) => {
                JointPosition::Along([a + way(a, c) * t, b + way(b, d) * t])
            }
            (JointPosition::Turn(a), JointPosition::Turn(b)) => JointPosition::Turn(turned(a, b)),
            (JointPosition::Free(a, p), JointPosition::Free(b, q)) => {
                JointPosition::Free(turned(a, b), p.lerp(q, t))
            }
            _ => *from,
        }
    }
}

/// Returns the rotation axes of a spherical joint in the body: with a range, the axis towards its end and two
/// perpendicular axes.
fn basis(state: &JointPosition, range: JointRange) -> [DVec3; 3] {
    match (*state, range) {
        (JointPosition::Turn(q), JointRange::Turn(_)) => {
            let Some(out) = rotation_vector(q).try_normalize() else { return DVec3::AXES };
            let (across, other) = out.any_orthonormal_pair();
            [out, across, other]
        }
        _ => DVec3::AXES,
    }
}

/// Returns axis times angle, the angle in [0, π].
pub(super) fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    let scale = if sine < 1e-150 { 2.0 } else { 2.0 * libm::atan2(sine, q.w) / sine };
    q.xyz() * scale
}
