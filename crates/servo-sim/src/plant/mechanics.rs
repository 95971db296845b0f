//! Computes mass matrix and bias forces of a mechanism in f64, with the composite-rigid-body and the recursive
//! Newton-Euler algorithm (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 5 and 6). All values are in world
//! axes about the world's origin.

use glam::{DMat3, DQuat, DVec3};
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Pose};

/// A spatial vector: the angular part, and the linear part at the world's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Spatial {
    turn: DVec3,
    slide: DVec3,
}

impl Spatial {
    fn plus(self, other: Self) -> Self {
        Self { turn: self.turn + other.turn, slide: self.slide + other.slide }
    }

    fn times(self, factor: f64) -> Self {
        Self { turn: self.turn * factor, slide: self.slide * factor }
    }

    fn dot(self, other: Self) -> f64 {
        self.turn.dot(other.turn) + self.slide.dot(other.slide)
    }

    /// Returns the rate of change of another motion that this motion carries along (spatial cross product).
    fn cross(self, motion: Self) -> Self {
        Self {
            turn: self.turn.cross(motion.turn),
            slide: self.turn.cross(motion.slide) + self.slide.cross(motion.turn),
        }
    }

    /// Returns the rate of change of a force or a momentum that this motion carries along (spatial cross product).
    fn cross_force(self, force: Self) -> Self {
        Self {
            turn: self.turn.cross(force.turn) + self.slide.cross(force.slide),
            slide: self.turn.cross(force.slide),
        }
    }
}

/// Mass, first moment and inertia about the world's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct SpatialInertia {
    mass_kg: f64,
    moment_kg_m: DVec3,
    inertia_kg_m2: DMat3,
}

impl SpatialInertia {
    /// Returns the momentum of a motion, or the force of an acceleration.
    fn times(&self, motion: Spatial) -> Spatial {
        Spatial {
            turn: self.inertia_kg_m2 * motion.turn + self.moment_kg_m.cross(motion.slide),
            slide: motion.slide * self.mass_kg - self.moment_kg_m.cross(motion.turn),
        }
    }

    fn plus(&self, other: &Self) -> Self {
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            moment_kg_m: self.moment_kg_m + other.moment_kg_m,
            inertia_kg_m2: self.inertia_kg_m2 + other.inertia_kg_m2,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Moving {
    velocity: Spatial,
    acceleration: Spatial,
    /// Force that the body and its descendants need for their motion.
    force: Spatial,
    own: SpatialInertia,
    composite: SpatialInertia,
}

/// State of a mechanism at an instant. [`Self::set`] computes all results. O(n · depth).
#[derive(Debug, Clone)]
pub(super) struct Mechanics {
    pub(super) mechanism: Mechanism,
    gravity_m_s2: DVec3,
    /// Index of the first dof and of the first coordinate of each body.
    pub(super) places: Vec<[usize; 2]>,
    motions: Vec<Spatial>,
    bodies: Vec<Moving>,
    /// Mass matrix, row by row.
    mass: Vec<f64>,
    bias: Vec<f64>,
}

impl Mechanics {
    pub(super) fn new(mechanism: &Mechanism, gravity_m_s2: DVec3) -> Self {
        let (mut places, mut dofs, mut coordinates) = (Vec::new(), 0, 0);
        for link in &mechanism.bodies {
            places.push([dofs, coordinates]);
            dofs += link.joint.kind().dof_count();
            coordinates += link.joint.kind().coordinate_count();
        }
        Self {
            mechanism: mechanism.clone(),
            gravity_m_s2,
            places,
            motions: vec![Spatial::default(); dofs],
            bodies: vec![Moving::default(); mechanism.bodies.len()],
            mass: vec![0.0; dofs * dofs],
            bias: vec![0.0; dofs],
        }
    }

    pub(super) fn dofs(&self) -> usize {
        self.bias.len()
    }

    /// Returns the dofs of a body's joint.
    pub(super) fn dofs_of(&self, body: usize) -> std::ops::Range<usize> {
        let first = self.places[body][0];
        first..first + self.mechanism.bodies[body].joint.kind().dof_count()
    }

    /// Returns an element of the mass matrix, kg m², kg m or kg; without rotors.
    pub(super) fn mass(&self, row: usize, column: usize) -> f64 {
        self.mass[row * self.dofs() + column]
    }

    /// Returns the effort of a dof for motion without acceleration, N m or N: gravity, Coriolis, centrifugal.
    pub(super) fn bias(&self, dof: usize) -> f64 {
        self.bias[dof]
    }

    /// Computes all results at positions and speeds in the order of `sinew_core::coordinates`.
    pub(super) fn set(&mut self, q: &[f64], qd: &[f64]) {
        let poses = self.mechanism.poses(q);
        for (index, pose) in poses.iter().enumerate() {
            self.outward(index, pose, q, qd);
        }
        self.mass.fill(0.0);
        for index in (0..poses.len()).rev() {
            self.inward(index);
        }
    }

    /// Computes velocity, acceleration without joint accelerations, and inertia of a body.
    fn outward(&mut self, index: usize, pose: &Pose, q: &[f64], qd: &[f64]) {
        let link = &self.mechanism.bodies[index];
        let carrier = match link.parent {
            Some(parent) => self.bodies[parent],
            None => Moving {
                acceleration: Spatial { turn: DVec3::ZERO, slide: -self.gravity_m_s2 },
                ..Moving::default()
            },
        };
        let (turns, slides) = link.joint.axes(&q[self.places[index][1]..]);
        let turns = turns.into_iter().map(|axis| {
            let turn = pose.rotation * axis;
            Spatial { turn, slide: pose.position_m.cross(turn) }
        });
        let slides = slides
            .into_iter()
            .map(|axis| Spatial { turn: DVec3::ZERO, slide: pose.rotation * axis });
        let first = self.places[index][0];
        let (mut joint, mut rest) = (Spatial::default(), Spatial::default());
        for (dof, motion) in (first..).zip(turns.chain(slides)) {
            self.motions[dof] = motion;
            let own = motion.times(qd[dof]);
            // The first turn carries the second axis of a universal joint; all other axes are fixed in the body.
            if matches!(link.joint, JointModel::Universal(_)) {
                rest = rest.plus(joint.cross(own));
            }
            joint = joint.plus(own);
        }
        let velocity = carrier.velocity.plus(joint);
        let acceleration = carrier.acceleration.plus(carrier.velocity.cross(joint)).plus(rest);
        let own = inertia_of(link, pose);
        let force = own.times(acceleration).plus(velocity.cross_force(own.times(velocity)));
        self.bodies[index] = Moving { velocity, acceleration, force, own, composite: own };
    }

    /// Computes bias and mass matrix row of a joint, and adds the body to its parent.
    fn inward(&mut self, index: usize) {
        let Moving { force, composite, .. } = self.bodies[index];
        let size = self.dofs();
        for row in self.dofs_of(index) {
            self.bias[row] = self.motions[row].dot(force);
            let moved = composite.times(self.motions[row]);
            let mut body = Some(index);
            while let Some(at) = body {
                for column in self.dofs_of(at) {
                    let element = self.motions[column].dot(moved);
                    self.mass[row * size + column] = element;
                    self.mass[column * size + row] = element;
                }
                body = self.mechanism.bodies[at].parent;
            }
        }
        if let Some(parent) = self.mechanism.bodies[index].parent {
            let carrier = &mut self.bodies[parent];
            carrier.force = carrier.force.plus(force);
            carrier.composite = carrier.composite.plus(&composite);
        }
    }

    /// Returns kinetic plus potential energy, without rotors, J.
    pub(super) fn energy_j(&self) -> f64 {
        let of_body = |body: &Moving| {
            0.5 * body.velocity.dot(body.own.times(body.velocity))
                - self.gravity_m_s2.dot(body.own.moment_kg_m)
        };
        self.bodies.iter().map(of_body).sum()
    }
}

fn inertia_of(link: &sinew_rig::mechanism::Link, pose: &Pose) -> SpatialInertia {
    let center = pose.point(link.center_of_mass_m);
    let turned = DMat3::from_quat(pose.rotation);
    let outer = DMat3::from_cols(center * center.x, center * center.y, center * center.z);
    let around = (DMat3::from_diagonal(DVec3::splat(center.dot(center))) - outer) * link.mass_kg;
    SpatialInertia {
        mass_kg: link.mass_kg,
        moment_kg_m: center * link.mass_kg,
        inertia_kg_m2: turned * link.inertia_kg_m2 * turned.transpose() + around,
    }
}

/// Moves the positions `q` for a time at constant speeds.
pub(super) fn advance(mechanics: &Mechanics, q: &mut [f64], qd: &[f64], dt_s: f64) {
    for (link, [dof, coordinate]) in mechanics.mechanism.bodies.iter().zip(&mechanics.places) {
        let speeds = &qd[*dof..];
        let own = &mut q[*coordinate..];
        match (link.joint, own, speeds) {
            (JointModel::Spherical, [x, y, z, w, ..], [a, b, c, ..]) => {
                let turn = DQuat::from_scaled_axis(DVec3::new(*a, *b, *c) * dt_s);
                let after = (DQuat::from_xyzw(*x, *y, *z, *w) * turn).normalize();
                [*x, *y, *z, *w] = after.to_array();
            }
            // The base does not move in the simulation, even if its joint is free.
            (JointModel::Free | JointModel::Fixed, ..) => {}
            (_, own, speeds) => {
                let count = link.joint.kind().dof_count();
                for (q, qd) in own.iter_mut().zip(speeds).take(count) {
                    *q += dt_s * qd;
                }
            }
        }
    }
}
