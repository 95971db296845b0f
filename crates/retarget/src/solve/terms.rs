//! Terms of the solver: directions, orientations, twists and positions, each with the dofs that move it.

use glam::{DMat3, DQuat, DVec3};

use super::model::{Model, State};
use super::normal::Normal;
use crate::rig::RigPoint;

/// A property of a rig that has a target.
#[derive(Debug, Clone)]
pub(super) enum Kind {
    /// Direction from one point to another.
    Direction { from: RigPoint, to: RigPoint },
    /// Vector from one point to another, m.
    Way { from: RigPoint, to: RigPoint },
    /// Orientation of a body; `upright` is forward, left, up in its frame.
    Orientation { body: usize, upright: DQuat },
    /// Rotation of a body about a limb, measured by the axis of the hinge on that body.
    Twist { body: usize, axis: DVec3, from: RigPoint, to: RigPoint },
    /// Position of a point; `parts` are the factors on the weight, `[horizontal, vertical]`.
    Position { point: RigPoint, parts: [f64; 2] },
}

/// Target of a term in a frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Target {
    /// Target of a direction, a vector, a twist, or a position.
    pub(super) vector: DVec3,
    /// Target of an orientation.
    pub(super) rotation: DQuat,
    /// Weight; zero without a target.
    pub(super) weight: f64,
}

impl Target {
    pub(super) const NONE: Self =
        Self { vector: DVec3::ZERO, rotation: DQuat::IDENTITY, weight: 0.0 };
}

/// Effect of a dof on a term.
#[derive(Debug, Clone, Copy)]
struct Mover {
    dof: usize,
    /// The dof that the solver changes: `dof` itself, or the dof that `dof` follows with this factor.
    leader: usize,
    factor: f64,
    /// Whether the dof moves the point where a direction begins, and the point where it ends.
    from: bool,
    to: bool,
    slides: bool,
}

impl Mover {
    /// Returns the change of the vector between two points for a unit motion of the dof.
    fn moved(&self, state: &State, [from_m, to_m]: [DVec3; 2]) -> DVec3 {
        let (axis, anchor) = (state.axes[self.dof], state.anchors_m[self.dof]);
        if self.slides {
            return if self.to { axis } else { -axis };
        }
        // If both points rotate together, only the vector between them matters.
        match (self.from, self.to) {
            (true, true) => axis.cross(to_m - from_m),
            (false, _) => axis.cross(to_m - anchor),
            (true, false) => -axis.cross(from_m - anchor),
        }
    }
}

/// A property with the dofs that affect it.
#[derive(Debug, Clone)]
pub(super) struct Term {
    pub(super) kind: Kind,
    movers: Vec<Mover>,
}

impl Term {
    pub(super) fn new(model: &Model, kind: Kind) -> Self {
        let (from, to) = match &kind {
            Kind::Direction { from, to } | Kind::Way { from, to } => (Some(from.body), to.body),
            Kind::Orientation { body, .. } | Kind::Twist { body, .. } => (None, *body),
            Kind::Position { point, .. } => (None, point.body),
        };
        let (from, to) = (from.map_or(Vec::new(), |body| model.supports(body)), model.supports(to));
        let mut dofs: Vec<usize> = from.iter().chain(&to).copied().collect();
        dofs.sort_unstable();
        dofs.dedup();
        // Dofs that slide and have no effect on the term are left out.
        let is_kept = |mover: &Mover| match kind {
            Kind::Direction { .. } | Kind::Way { .. } => mover.from && mover.to,
            Kind::Orientation { .. } | Kind::Twist { .. } => true,
            Kind::Position { .. } => false,
        };
        let movers = dofs
            .into_iter()
            .map(|dof| {
                let (leader, factor) = model.leader(dof);
                let (from, to) = (from.contains(&dof), to.contains(&dof));
                Mover { dof, leader, factor, from, to, slides: model.slides[dof] }
            })
            .filter(|mover| !(mover.slides && is_kept(mover)))
            .collect();
        Self { kind, movers }
    }

    pub(super) fn dofs(&self) -> impl Iterator<Item = usize> + '_ {
        self.movers.iter().map(|mover| mover.leader)
    }

    /// Returns the squared error times its weight.
    pub(super) fn cost(&self, state: &State, target: &Target) -> f64 {
        if target.weight <= 0.0 {
            return 0.0;
        }
        let squared = match &self.kind {
            Kind::Direction { from, to } => {
                let way = (state.point_m(to) - state.point_m(from)).normalize_or_zero();
                (way - target.vector).length_squared()
            }
            Kind::Way { from, to } => {
                (state.point_m(to) - state.point_m(from) - target.vector).length_squared()
            }
            Kind::Orientation { body, upright } => {
                turn_between(target.rotation, state.rotations[*body] * *upright).length_squared()
            }
            Kind::Twist { body, axis, from, to } => {
                twist(state, *body, *axis, from, to, target.vector)
                    .map_or(0.0, |(_, twist)| twist * twist)
            }
            Kind::Position { point, parts } => {
                let away = state.point_m(point) - target.vector;
                (away * away * by_axis(*parts)).element_sum()
            }
        };
        squared * target.weight
    }

    /// Adds the term to the normal equations.
    pub(super) fn add(&self, state: &State, target: &Target, normal: &mut Normal) {
        if target.weight <= 0.0 {
            return;
        }
        match &self.kind {
            Kind::Direction { from, to } => {
                let (from_m, to_m) = (state.point_m(from), state.point_m(to));
                let way = to_m - from_m;
                let length = way.length();
                if length <= f64::EPSILON {
                    return;
                }
                let u = way / length;
                let error = u - target.vector;
                for mover in &self.movers {
                    let moved = mover.moved(state, [from_m, to_m]);
                    normal.column(mover.leader, mover.factor * (moved - u * u.dot(moved)) / length);
                }
                normal.add(error, DVec3::splat(target.weight));
            }
            Kind::Way { from, to } => {
                let ends_m = [state.point_m(from), state.point_m(to)];
                for mover in &self.movers {
                    normal.column(mover.leader, mover.factor * mover.moved(state, ends_m));
                }
                let error = ends_m[1] - ends_m[0] - target.vector;
                normal.add(error, DVec3::splat(target.weight));
            }
            Kind::Orientation { body, upright } => {
                let error = turn_between(target.rotation, state.rotations[*body] * *upright);
                for mover in &self.movers {
                    normal.column(mover.leader, mover.factor * state.axes[mover.dof]);
                }
                normal.add(error, DVec3::splat(target.weight));
            }
            Kind::Twist { body, axis, from, to } => {
                let Some((u, angle)) = twist(state, *body, *axis, from, to, target.vector) else {
                    return;
                };
                for mover in &self.movers {
                    let along = mover.factor * u.dot(state.axes[mover.dof]);
                    normal.column(mover.leader, DVec3::X * along);
                }
                normal.add(DVec3::X * angle, DVec3::X * target.weight);
            }
            Kind::Position { point, parts } => {
                let point_m = state.point_m(point);
                for mover in &self.movers {
                    let axis = state.axes[mover.dof];
                    let moved = if mover.slides {
                        axis
                    } else {
                        axis.cross(point_m - state.anchors_m[mover.dof])
                    };
                    normal.column(mover.leader, mover.factor * moved);
                }
                normal.add(point_m - target.vector, by_axis(*parts) * target.weight);
            }
        }
    }
}

fn by_axis([horizontal, vertical]: [f64; 2]) -> DVec3 {
    DVec3::new(horizontal, vertical, horizontal)
}

/// Returns the shorter rotation from one orientation to another as a rotation vector in the world, rad.
fn turn_between(from: DQuat, to: DQuat) -> DVec3 {
    let turn = to * from.conjugate();
    let turn = if turn.w < 0.0 { -turn } else { turn };
    let sine = turn.xyz().length();
    if sine < 1e-12 {
        return 2.0 * turn.xyz();
    }
    turn.xyz() * (2.0 * libm::atan2(sine, turn.w) / sine)
}

/// Minimum sine between the hinge's axis and the limb. If they are nearly parallel, the twist angle has no meaning.
const LEAST: f64 = 0.1;

/// Returns the direction of a limb, and the angle about it from `wanted` to the hinge's axis; `None` if either is
/// nearly parallel to the limb.
fn twist(
    state: &State,
    body: usize,
    axis: DVec3,
    from: &RigPoint,
    to: &RigPoint,
    wanted: DVec3,
) -> Option<(DVec3, f64)> {
    let u = (state.point_m(to) - state.point_m(from)).try_normalize()?;
    let across = |v: DVec3| v - u * u.dot(v);
    let (have, want) = (across(state.rotations[body] * axis), across(wanted));
    let is_short = |v: DVec3| v.length_squared() < LEAST * LEAST;
    if is_short(have) || is_short(want) {
        return None;
    }
    Some((u, libm::atan2(u.dot(want.cross(have)), want.dot(have))))
}

/// Returns the rotation whose matrix has the columns forward, left and up, in a body's frame.
pub(super) fn upright(rotation_at_zero: DQuat, directions: DMat3) -> DQuat {
    (rotation_at_zero.conjugate() * DQuat::from_mat3(&directions)).normalize()
}
