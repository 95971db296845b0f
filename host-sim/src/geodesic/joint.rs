//! One joint of a pose: its state, how it moves, and its range.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};
use sinew_core::JointKind;
use sinew_core::projection::JointRange;

/// What a joint leaves free.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum JointPosition {
    /// Nothing.
    Fixed,
    /// Angles in rad or way in m of a joint with one or two axes; unused ones are 0.
    Along([f64; 2]),
    /// Rotation in the joint frame of a spherical joint.
    Turn(DQuat),
    /// Rotation and position in the joint frame of a free joint.
    Free(DQuat, DVec3),
}

/// A direction that a joint can move in: how the body moves when its coordinate does, in the world.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axis {
    pub(super) angular: DVec3,
    pub(super) linear: DVec3,
}

/// How a joint is made.
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
    pub(super) fn degrees_of_freedom(self) -> usize {
        match self {
            Self::Fixed => 0,
            Self::Revolute(_) | Self::Prismatic(_) => 1,
            Self::Universal(..) => 2,
            Self::Spherical => 3,
            Self::Free => 6,
        }
    }

    /// Whether the state is one that such a joint has.
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

    /// Rotation and position in the joint frame.
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

    /// The directions that a joint can move in, outer ones first. `frame`: rotation of the joint frame in the world,
    /// `body`: of the body. At the end of a turn's range, the first is the way out.
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

    /// Of each axis, whether the state is at its range's lower end, and at its upper one.
    pub(super) fn ends(self, state: &JointPosition, range: JointRange, out: &mut Vec<[bool; 2]>) {
        let side = |x: f64, [least, most]: [f32; 2]| [x <= f64::from(least), x >= f64::from(most)];
        match (range, *state) {
            (JointRange::Axis(ends), JointPosition::Along([a, _])) => out.push(side(a, ends)),
            (JointRange::Axes([first, second]), JointPosition::Along([a, b])) => {
                out.extend([side(a, first), side(b, second)]);
            }
            (JointRange::Turn(most), JointPosition::Turn(q)) => {
                out.extend([[false, is_at_end(q, most)], [false; 2], [false; 2]]);
            }
            _ => out.extend(std::iter::repeat_n([false; 2], self.degrees_of_freedom())),
        }
    }

    /// How much the end of the range that the state is at bends inwards, per rad, seen across the first axis: of
    /// turns up to `m` from the middle, ½ cot(m/2) (the second derivative of the angle across the way out).
    pub(super) fn bend_of_end(state: &JointPosition, range: JointRange) -> Option<f64> {
        match (range, *state) {
            (JointRange::Turn(most), JointPosition::Turn(q)) if is_at_end(q, most) => {
                Some(0.5 / libm::tan(0.5 * f64::from(most)))
            }
            _ => None,
        }
    }

    /// The state after a step along its axes, brought back within the range.
    pub(super) fn stepped(state: &JointPosition, range: JointRange, step: &[f64]) -> JointPosition {
        let within = |x: f64, [least, most]: [f32; 2]| x.max(f64::from(least)).min(f64::from(most));
        match (*state, step) {
            (JointPosition::Along([a, _]), [da]) => {
                let a = a + da;
                JointPosition::Along([
                    if let JointRange::Axis(ends) = range { within(a, ends) } else { a },
                    0.0,
                ])
            }
            (JointPosition::Along([a, b]), [da, db]) => {
                let (a, b) = (a + da, b + db);
                JointPosition::Along(match range {
                    JointRange::Axes([first, second]) => [within(a, first), within(b, second)],
                    _ => [a, b],
                })
            }
            (JointPosition::Turn(q), [x, y, z]) => {
                let [e, f, g] = basis(state, range);
                let turned = (q * DQuat::from_scaled_axis(e * *x + f * *y + g * *z)).normalize();
                JointPosition::Turn(match range {
                    JointRange::Turn(most) if is_at_end(turned, most) => {
                        let vector = rotation_vector(turned);
                        DQuat::from_scaled_axis(vector.normalize() * f64::from(most))
                    }
                    _ => turned,
                })
            }
            (JointPosition::Free(q, p), [x, y, z, tx, ty, tz]) => JointPosition::Free(
                (q * DQuat::from_scaled_axis(DVec3::new(*x, *y, *z))).normalize(),
                p + DVec3::new(*tx, *ty, *tz),
            ),
            _ => *state,
        }
    }

    /// The state a share `t` of the way from one to another, the shorter way round where no range is in it.
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

/// Turning axes of a spherical joint in the body: at the end of its range, the way out and two across it.
fn basis(state: &JointPosition, range: JointRange) -> [DVec3; 3] {
    match (*state, range) {
        (JointPosition::Turn(q), JointRange::Turn(most)) if is_at_end(q, most) => {
            let out = rotation_vector(q).normalize();
            let (across, other) = out.any_orthonormal_pair();
            [out, across, other]
        }
        _ => DVec3::AXES,
    }
}

/// Whether a turn is as far as it may be; what rounding brings inside is at the end too.
fn is_at_end(q: DQuat, most_rad: f32) -> bool {
    rotation_vector(q).length() >= f64::from(most_rad) * (1.0 - 1e-14)
}

/// Axis times angle, the angle in [0, π].
pub(super) fn rotation_vector(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let sine = q.xyz().length();
    let scale = if sine < 1e-150 { 2.0 } else { 2.0 * libm::atan2(sine, q.w) / sine };
    q.xyz() * scale
}
