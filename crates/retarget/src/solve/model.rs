//! Kinematics of a rig for the solver: axes and anchors of every dof in the world.

use std::ops::Range;

use glam::{DQuat, DVec3};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Ties};

/// A body and its joint.
#[derive(Debug, Clone)]
struct Link {
    parent: Option<usize>,
    position_m: DVec3,
    rotation: DQuat,
    joint: JointModel,
    /// Range of the joint's coordinates in `q`.
    q: Range<usize>,
    /// Range of the joint's dofs.
    v: Range<usize>,
}

/// Constant data of a rig.
#[derive(Debug, Clone)]
pub(super) struct Model {
    links: Vec<Link>,
    pub(super) home: Vec<f64>,
    /// Minimum and maximum position, and maximum speed, of each dof; infinite without limit.
    pub(super) ranges: Vec<[f64; 2]>,
    pub(super) speeds: Vec<f64>,
    /// Coordinate of each dof, if the dof has one of its own.
    pub(super) coordinates: Vec<Option<usize>>,
    /// Whether each dof slides.
    pub(super) slides: Vec<bool>,
    /// Links of ball joints with a range, and their maximum angle, rad.
    cones: Vec<(usize, f64)>,
    /// Joints that follow others.
    ties: Ties,
}

/// Pose of a rig, with its axes.
#[derive(Debug, Clone)]
pub(super) struct State {
    pub(super) q: Vec<f64>,
    /// Rotation and position of each body, in the world.
    pub(super) rotations: Vec<DQuat>,
    pub(super) positions_m: Vec<DVec3>,
    /// Axis and anchor of each dof, in the world.
    pub(super) axes: Vec<DVec3>,
    pub(super) anchors_m: Vec<DVec3>,
}

impl Model {
    /// Creates the model. `speed` is the maximum speed of turning joints without a speed limit, rad/s.
    pub(super) fn of(mechanism: &Mechanism, speed: f64) -> Self {
        let mut model = Self {
            links: Vec::new(),
            home: mechanism.home(),
            ranges: Vec::new(),
            speeds: Vec::new(),
            coordinates: Vec::new(),
            slides: Vec::new(),
            cones: Vec::new(),
            ties: mechanism.ties(),
        };
        let q_ranges = mechanism.coordinate_ranges();
        for (index, (link, q)) in mechanism.bodies.iter().zip(&q_ranges).enumerate() {
            let first = model.ranges.len();
            let count = link.joint.kind().dof_count();
            let is_free = matches!(link.joint, JointModel::Free);
            for axis in 0..count {
                let single = matches!(
                    link.joint,
                    JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_)
                );
                let range = link.ranges.get(axis).copied().filter(|_| single);
                model.ranges.push(range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]));
                let slides = matches!(link.joint, JointModel::Prismatic(_)) || is_free && axis >= 3;
                let own = if link.speed.is_finite() || slides { link.speed } else { speed };
                model.speeds.push(if is_free { f64::INFINITY } else { own });
                model.coordinates.push(single.then_some(q.start + axis));
                model.slides.push(slides);
            }
            if let (JointModel::Spherical, Some([_, most])) = (link.joint, link.ranges.first()) {
                model.cones.push((index, *most));
            }
            model.links.push(Link {
                parent: link.parent,
                position_m: link.position_m,
                rotation: link.rotation,
                joint: link.joint,
                q: q.clone(),
                v: first..first + count,
            });
        }
        model
    }

    pub(super) fn dof_count(&self) -> usize {
        self.ranges.len()
    }

    pub(super) fn state(&self) -> State {
        let mut state = State {
            q: self.home.clone(),
            rotations: vec![DQuat::IDENTITY; self.links.len()],
            positions_m: vec![DVec3::ZERO; self.links.len()],
            axes: vec![DVec3::ZERO; self.dof_count()],
            anchors_m: vec![DVec3::ZERO; self.dof_count()],
        };
        self.place(&mut state);
        state
    }

    /// Returns the dofs that move a body, from the base outwards.
    pub(super) fn supports(&self, body: usize) -> Vec<usize> {
        let way = std::iter::successors(Some(body), |body| self.links[*body].parent);
        let mut dofs: Vec<usize> = way.flat_map(|body| self.links[body].v.clone()).collect();
        dofs.sort_unstable();
        dofs
    }

    /// Returns the dof that must be changed to move `dof`, and the motion of `dof` for a unit motion of that dof: the
    /// dof itself and 1, or the dof that it follows and a factor.
    pub(super) fn leader(&self, dof: usize) -> (usize, f64) {
        let tie = self.ties.each().find(|tie| tie.dofs()[0] == dof);
        tie.map_or((dof, 1.0), |tie| (tie.dofs()[1], tie.factor))
    }

    /// Returns the dofs of the base.
    pub(super) fn base_dofs(&self) -> Range<usize> {
        self.links[0].v.clone()
    }

    /// Places all bodies according to `q`. O(n).
    pub(super) fn place(&self, state: &mut State) {
        let State { q, rotations, positions_m, axes, anchors_m } = state;
        self.ties.follow(q);
        for (body, link) in self.links.iter().enumerate() {
            let (position_m, rotation) = match link.parent {
                None => (link.position_m, link.rotation),
                Some(parent) => (
                    positions_m[parent] + rotations[parent] * link.position_m,
                    rotations[parent] * link.rotation,
                ),
            };
            let q = &q[link.q.clone()];
            let moved = link.joint.motion(q);
            positions_m[body] = position_m + rotation * moved.position_m;
            // Without normalization, rounding errors would grow along the chain, and from frame to frame of a free
            // base.
            rotations[body] = (rotation * moved.rotation).normalize();
            let axes = &mut axes[link.v.clone()];
            match link.joint {
                JointModel::Fixed => {}
                JointModel::Revolute(axis) | JointModel::Prismatic(axis) => {
                    axes[0] = rotation * axis;
                }
                JointModel::Universal([first, second]) => {
                    axes[0] = rotation * first;
                    axes[1] = rotations[body] * second;
                }
                JointModel::Spherical => axes.copy_from_slice(&DVec3::AXES),
                JointModel::Free => {
                    axes[..3].copy_from_slice(&DVec3::AXES);
                    axes[3..].copy_from_slice(&DVec3::AXES);
                }
            }
            anchors_m[link.v.clone()].fill(positions_m[body]);
        }
    }

    /// Moves the dofs by `step`, and places the bodies.
    pub(super) fn advance(&self, state: &mut State, step: &[f64]) {
        for link in &self.links {
            let (q, step) = (&mut state.q[link.q.clone()], &step[link.v.clone()]);
            match link.joint {
                JointModel::Fixed => {}
                JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
                    for (q, step) in q.iter_mut().zip(step) {
                        *q += step;
                    }
                }
                JointModel::Spherical | JointModel::Free => {
                    // Steps are about world axes; `q` rotates in the axes of the joint.
                    let frame = link
                        .parent
                        .map_or(link.rotation, |parent| state.rotations[parent] * link.rotation);
                    let back = frame.conjugate();
                    let turn = DQuat::from_scaled_axis(back * DVec3::from_slice(step));
                    let rotation = turn * DQuat::from_slice(q);
                    rotation.normalize().write_to_slice(q);
                    if let (JointModel::Free, Some(slide)) = (link.joint, step.get(3..6)) {
                        let moved = DVec3::from_slice(&q[4..]) + back * DVec3::from_slice(slide);
                        moved.write_to_slice(&mut q[4..]);
                    }
                }
            }
        }
        for (link, most) in &self.cones {
            let q = &mut state.q[self.links[*link].q.clone()];
            let turn = DQuat::from_slice(q).to_scaled_axis();
            if turn.length() > *most {
                DQuat::from_scaled_axis(turn.clamp_length_max(*most)).write_to_slice(q);
            }
        }
        self.place(state);
    }

    /// Computes the differences of the dofs from `from` into `away`. `state` must be placed.
    pub(super) fn away(&self, state: &State, from: &[f64], away: &mut [f64]) {
        for link in &self.links {
            let (q, from) = (&state.q[link.q.clone()], &from[link.q.clone()]);
            let away = &mut away[link.v.clone()];
            match link.joint {
                JointModel::Fixed => {}
                JointModel::Revolute(_) | JointModel::Prismatic(_) | JointModel::Universal(_) => {
                    for (away, (q, from)) in away.iter_mut().zip(q.iter().zip(from)) {
                        *away = q - from;
                    }
                }
                JointModel::Spherical | JointModel::Free => {
                    let frame = link
                        .parent
                        .map_or(link.rotation, |parent| state.rotations[parent] * link.rotation);
                    let turn = DQuat::from_slice(q) * DQuat::from_slice(from).conjugate();
                    let turn = if turn.w < 0.0 { -turn } else { turn };
                    (frame * turn.normalize().to_scaled_axis()).write_to_slice(away);
                    if let (JointModel::Free, Some(slid)) = (link.joint, away.get_mut(3..6)) {
                        let moved = DVec3::from_slice(&q[4..]) - DVec3::from_slice(&from[4..]);
                        (frame * moved).write_to_slice(slid);
                    }
                }
            }
        }
    }

    /// Rotates a free base so that a body has the wanted orientation, which a start needs. A fixed base is
    /// unchanged.
    pub(super) fn turn_base(&self, state: &mut State, body: usize, wanted: DQuat) {
        let base = &self.links[0];
        if !matches!(base.joint, JointModel::Free) {
            return;
        }
        let turn = wanted * state.rotations[body].conjugate();
        let rotation = base.rotation.conjugate() * (turn * state.rotations[0]);
        rotation.normalize().write_to_slice(&mut state.q[base.q.clone()]);
        self.place(state);
    }
}

impl State {
    /// Returns a point of a body in the world, m.
    pub(super) fn point_m(&self, point: &crate::rig::RigPoint) -> DVec3 {
        self.positions_m[point.body] + self.rotations[point.body] * point.position_m
    }
}
