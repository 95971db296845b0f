//! A whole rig on the shafts of its servos: what one moves, the others feel, and gravity is that of the pose.
//!
//! The speeds of all joints after a step are one system of linear equations, implicit in frictions, stops and gears:
//! stable at any stiffness of theirs. A servo solves its own step before the rig moves, so it foresees its shaft: it
//! takes the acceleration of the last step, and that its own torque changes it by `1 / Σ |W|` over the row of
//! `W = B M⁻¹ Bᵀ`, the shafts' accelerations for torques on all. This decides whether teeth touch and what friction
//! holds. Then the rig moves with the torque of the gear as a line over the shaft's speed ([`Push`]), and shaft and rotor
//! go where that system has them: an explicit torque, of the foreseen speed alone, makes light bodies on stiff gears
//! diverge. Where all is at rest the foreseen shaft is the real one, so friction holds a joint where it is; what begins
//! to push a joint moves it until the servos have felt it, some steps long.

mod drives;
mod hand;
mod mechanics;
mod symmetric;

use std::ops::Range;

use glam::DVec3;
use sinew_rig::drive::DriveInputError;
use sinew_rig::mechanism::{GRAVITY_M_S2, JointModel};
use sinew_rig::{Description, Mechanism};

use crate::load::{Arm, Plant, Push, STOP_DAMPING_S, STOP_N_M, STOP_NM_RAD, Shaft};
use crate::model::Parameters;
use crate::rig::{HORN_KG_M2, RigServosError};
use drives::Driven;
pub use hand::Hand;
use hand::{Grip, Holds};
use mechanics::{Mechanics, advance};
use symmetric::Symmetric;

/// Below this speed Coulomb friction of joints grows in proportion, rad/s or m/s: a joint at rest creeps.
const CREEP: f64 = 1e-3;
/// The least inertia of a joint that no servo moves, kg m² or kg: what has none would follow no force.
const LEAST_INERTIA: f64 = 1e-6;
/// Below this, the square of a number is none.
const LEAST_PIVOT: f64 = 1e-15;

/// A rig that servos of one bench move.
///
/// The base stands. Joints of drives whose servos are not all on the bench stay at home; those that no servo moves
/// swing, with what the rig's file says of their friction. Left out: limits that join two joints, ranges of ball
/// joints, and stiction of joints (servos have their own).
#[derive(Debug, Clone)]
pub struct RigPlant {
    mechanics: Mechanics,
    q: Vec<f64>,
    qd: Vec<f64>,
    drives: Vec<Driven>,
    /// By way to move: speeds of dofs.
    joints: Vec<Vec<(usize, f64)>>,
    /// By way to move: speeds of servos.
    shafts: Vec<Vec<(usize, f64)>>,
    /// The ways of each drive.
    places: Vec<Range<usize>>,
    speeds: Vec<f64>,
    /// By way to move: inertia beside that of the bodies.
    extra: Vec<f64>,
    /// By dof.
    frictions: Vec<Friction>,
    ends: Vec<End>,
    hands: Vec<Holds>,
    /// By dof: effort from outside, N m or N.
    pushes: Vec<f64>,
    /// By servo: least and most own position, rad.
    stops_rad: Vec<[f64; 2]>,
    own: Vec<Shaft>,
    loads: Vec<Arm>,
    /// Inertias of the ways with frictions and stops; [`Self::coupled`] has the gears, too.
    matrix: Symmetric,
    coupled: Symmetric,
}

#[derive(Debug, Clone, Copy, Default)]
struct Friction {
    coulomb: f64,
    viscous: f64,
}

/// Ends of a dof's range.
#[derive(Debug, Clone, Copy)]
struct End {
    dof: usize,
    coordinate: usize,
    range: [f64; 2],
    stiffness: f64,
}

impl RigPlant {
    /// A rig at rest at its home pose. `servos`: names of those on the bench, in their order there.
    ///
    /// # Errors
    /// [`RigServosError`], also if a name is none of a servo.
    pub fn new(
        description: &Description,
        mechanism: &Mechanism,
        servos: &[&str],
    ) -> Result<Self, RigServosError> {
        Self::under(description, mechanism, servos, GRAVITY_M_S2)
    }

    fn under(
        description: &Description,
        mechanism: &Mechanism,
        servos: &[&str],
        gravity_m_s2: DVec3,
    ) -> Result<Self, RigServosError> {
        let actuation = description.actuation()?;
        let mechanics = Mechanics::new(mechanism, gravity_m_s2);
        let mut benched = vec![None; description.servos.len()];
        let mut stops_rad = Vec::new();
        for (place, name) in servos.iter().enumerate() {
            let index = description.servos.iter().position(|servo| servo.name == *name);
            let index = index.ok_or_else(|| RigServosError::NoServo((*name).to_owned()))?;
            let described = &description.servos[index];
            // `actuation` has refused models that are not known.
            let Some(model) = description.servo_model(&described.model) else { continue };
            let middle = 0.5 * Parameters::of_model(&model)?.range_rad;
            benched[index] = Some((place, middle));
            let range = actuation.servos[index].settings().range_rad;
            stops_rad.push(range.map(|end| f64::from(end) + middle));
        }
        let body_of = |name: &str| mechanism.bodies.iter().position(|link| link.joint_name == name);
        let bodies: Vec<_> = description.joints.iter().map(|joint| body_of(&joint.name)).collect();
        let drives: Vec<Driven> = actuation
            .drives
            .iter()
            .filter_map(|of| Driven::new(of, &actuation.servos, &mechanics, &bodies, &benched))
            .collect();
        let mut plant = Self {
            q: mechanism.home(),
            qd: vec![0.0; mechanics.dofs()],
            joints: Vec::new(),
            shafts: Vec::new(),
            places: Vec::new(),
            speeds: Vec::new(),
            extra: Vec::new(),
            frictions: vec![Friction::default(); mechanics.dofs()],
            ends: Vec::new(),
            hands: Vec::new(),
            pushes: vec![0.0; mechanics.dofs()],
            own: vec![Shaft::default(); servos.len()],
            loads: vec![Arm::default(); servos.len()],
            matrix: Symmetric::default(),
            coupled: Symmetric::default(),
            mechanics,
            drives,
            stops_rad,
        };
        for drive in &plant.drives {
            drive.settle(&mut plant.q)?;
            let first = plant.joints.len();
            plant.places.push(first..first + drive.ways());
            plant.joints.resize(first + drive.ways(), Vec::new());
        }
        plant.shafts.resize(plant.joints.len(), Vec::new());
        let taken: Vec<usize> = actuation.drives.iter().flat_map(|of| of.joints.clone()).collect();
        for (joint, body) in bodies.iter().enumerate() {
            let Some(body) = *body else { continue };
            plant.take_joint(description, joint, body, !taken.contains(&joint));
        }
        let ways = plant.joints.len();
        (plant.speeds, plant.extra) = (vec![0.0; ways], vec![0.0; ways]);
        plant.matrix = Symmetric::zeros(ways);
        plant.coupled = Symmetric::zeros(ways);
        for drive in 0..plant.drives.len() {
            plant.take_ways(drive)?;
            plant.take_positions(drive)?;
        }
        plant.mechanics.set(&plant.q, &plant.qd);
        plant.take_extra();
        let at_rest = plant.own.clone();
        plant.accelerate(Self::STEP_S, &vec![Push::default(); servos.len()], &at_rest);
        Ok(plant)
    }

    /// Its step, s: that of the servos.
    const STEP_S: f64 = crate::device::STEP_S;

    /// Friction and ends of a joint; a way of its own for each dof, if no servo moves it.
    fn take_joint(&mut self, description: &Description, joint: usize, body: usize, is_free: bool) {
        let described = &description.joints[joint];
        let link = &self.mechanics.mechanism.bodies[body];
        let stiffness = match link.joint {
            JointModel::Free | JointModel::Fixed => return,
            JointModel::Prismatic(_) => STOP_N_M,
            _ => STOP_NM_RAD,
        };
        if link.joint != JointModel::Spherical {
            let [first, coordinate] = self.mechanics.places[body];
            self.ends.extend(link.ranges.iter().enumerate().map(|(axis, range)| End {
                dof: first + axis,
                coordinate: coordinate + axis,
                range: *range,
                stiffness,
            }));
        }
        for dof in self.mechanics.dofs_of(body) {
            self.frictions[dof] =
                Friction { coulomb: described.friction, viscous: described.damping };
            if is_free {
                self.joints.push(vec![(dof, 1.0)]);
                self.shafts.push(Vec::new());
            }
        }
    }

    /// The ways of a drive at the present pose.
    fn take_ways(&mut self, drive: usize) -> Result<(), DriveInputError> {
        let of = &self.drives[drive];
        let ways = of.ways_at(&of.at(&self.q)?)?;
        let named = |places: &[usize], speeds: &[f64]| {
            places.iter().copied().zip(speeds.iter().copied()).collect::<Vec<_>>()
        };
        let own = ways.joints.iter().zip(&ways.servos);
        for (way, (joints, servos)) in self.places[drive].clone().zip(own) {
            self.joints[way] = named(&of.dofs, joints);
            self.shafts[way] = named(&of.servos, servos);
        }
        Ok(())
    }

    /// Where a drive's servos are, by where the joints are.
    fn take_positions(&mut self, drive: usize) -> Result<(), DriveInputError> {
        let of = &self.drives[drive];
        for (servo, position_rad) in of.servos.iter().zip(of.positions_rad(&of.at(&self.q)?)) {
            self.own[*servo].position_rad = position_rad;
        }
        Ok(())
    }

    /// What is lighter at home than a horn on each servo has the inertia of that.
    fn take_extra(&mut self) {
        for way in 0..self.joints.len() {
            let moved = self.inertia(way, way);
            let turns: f64 = self.shafts[way].iter().map(|(_, speed)| speed * speed).sum();
            let (rotor, least) = if self.shafts[way].is_empty() {
                let body = (0..self.mechanics.mechanism.bodies.len())
                    .find(|body| self.mechanics.dofs_of(*body).contains(&self.joints[way][0].0));
                let rotor =
                    body.map_or(0.0, |at| self.mechanics.mechanism.bodies[at].rotor_inertia);
                (rotor, LEAST_INERTIA)
            } else {
                (0.0, HORN_KG_M2 * turns)
            };
            self.extra[way] = rotor.max(least - moved).max(0.0);
        }
    }

    /// Element of the mass matrix of the ways to move.
    fn inertia(&self, one: usize, other: usize) -> f64 {
        let mut sum = 0.0;
        for (row, speed) in &self.joints[one] {
            for (column, other_speed) in &self.joints[other] {
                sum += speed * other_speed * self.mechanics.mass(*row, *column);
            }
        }
        sum
    }

    /// A hand takes a joint's dof, or leads it on; none lets go. Hands do not take ball joints: then nothing
    /// happens, and it says so.
    pub fn lead(&mut self, dof: usize, hand: Option<Hand>) -> bool {
        self.hands.retain(|holds| holds.grip.dof != dof);
        let Some(grip) = Grip::new(&self.mechanics, dof) else { return false };
        self.hands.extend(hand.map(|hand| Holds { grip, hand }));
        true
    }

    /// Pushes a dof from outside with this torque, N m, or force of a slide, N, until it is told another one. Returns
    /// whether there is such a dof.
    pub fn push(&mut self, dof: usize, torque_nm: f64) -> bool {
        let Some(push) = self.pushes.get_mut(dof) else { return false };
        *push = torque_nm;
        true
    }

    /// Joint coordinates, as `sinew_core::coordinates` has them.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Speeds of the dofs, rad/s and m/s.
    pub fn qd(&self) -> &[f64] {
        &self.qd
    }

    /// Energy of motion and of height, without rotors and horns, J.
    pub fn energy_j(&mut self) -> f64 {
        self.mechanics.set(&self.q, &self.qd);
        self.mechanics.energy_j()
    }

    /// Accelerations of the ways over a step, and what each servo works against in the next one. `foreseen`: the shafts
    /// as the servos foresaw them.
    fn accelerate(&mut self, dt_s: f64, pushes: &[Push], foreseen: &[Shaft]) -> Vec<f64> {
        let ways = self.joints.len();
        self.matrix.fill(0.0);
        for row in 0..ways {
            for column in 0..=row {
                let inertia = self.inertia(row, column);
                self.matrix.add(row, column, inertia);
            }
            self.matrix.add(row, row, self.extra[row]);
        }
        let mut forces = vec![0.0; ways];
        for (way, force) in forces.iter_mut().enumerate() {
            let resists = |at: usize| self.mechanics.bias(at) - self.pushes[at];
            let of_joints: f64 =
                self.joints[way].iter().map(|(at, speed)| speed * resists(*at)).sum();
            *force = -of_joints;
        }
        self.resist(dt_s, &mut forces);
        self.coupled.copy_from(&self.matrix);
        for (servo, (push, shaft)) in pushes.iter().zip(foreseen).enumerate() {
            let slower_rad_s = shaft.velocity_rad_s - self.own[servo].velocity_rad_s;
            let torque_nm = push.torque_nm + push.slope_nm_s * slower_rad_s;
            let row = along(&self.shafts, servo);
            self.coupled.add_square(&row, dt_s * push.slope_nm_s);
            for (sum, share) in forces.iter_mut().zip(row) {
                *sum += share * torque_nm;
            }
        }
        self.coupled.factor(LEAST_PIVOT);
        self.coupled.solve(&mut forces);
        self.matrix.factor(LEAST_PIVOT);
        self.foresee(dt_s, &forces, pushes, foreseen);
        forces
    }

    /// Frictions and stops, implicit.
    fn resist(&mut self, dt_s: f64, forces: &mut [f64]) {
        let mut add = |row: &[f64], force: f64, slope: f64| {
            self.matrix.add_square(row, dt_s * slope);
            for (sum, share) in forces.iter_mut().zip(row) {
                *sum += share * force;
            }
        };
        for (dof, friction) in self.frictions.iter().enumerate() {
            let speed = self.qd[dof];
            let slope = friction.viscous + friction.coulomb / speed.abs().max(CREEP);
            if slope > 0.0 {
                add(&along(&self.joints, dof), -slope * speed, slope);
            }
        }
        for end in &self.ends {
            let (at, speed) = (self.q[end.coordinate], self.qd[end.dof]);
            if let Some((force, slope)) = stop(dt_s, end.stiffness, end.range, at, speed) {
                add(&along(&self.joints, end.dof), force, slope);
            }
        }
        for hand in &self.hands {
            let (force, slope) = hand.push(dt_s, &self.q, &self.qd);
            add(&along(&self.joints, hand.grip.dof), force, slope);
        }
        for (servo, (shaft, range)) in self.own.iter().zip(&self.stops_rad).enumerate() {
            let (at, speed) = (shaft.position_rad, shaft.velocity_rad_s);
            if let Some((force, slope)) = stop(dt_s, STOP_NM_RAD, *range, at, speed) {
                add(&along(&self.shafts, servo), force, slope);
            }
        }
    }

    /// What each servo works against in the next step: see [the module](self).
    fn foresee(&mut self, dt_s: f64, accelerations: &[f64], pushes: &[Push], foreseen: &[Shaft]) {
        let servos = self.own.len();
        let turned = |by: &[f64], list: &[Vec<(usize, f64)>]| {
            let mut turned = vec![0.0; servos];
            for (way, amount) in list.iter().zip(by) {
                for (servo, speed) in way {
                    turned[*servo] += speed * amount;
                }
            }
            turned
        };
        let now = turned(accelerations, &self.shafts);
        for servo in 0..servos {
            let mut response = along(&self.shafts, servo);
            self.matrix.solve(&mut response);
            let yields: f64 = turned(&response, &self.shafts).iter().map(|by| by.abs()).sum();
            // A servo that moves nothing of the rig has its horn.
            let inertia_kg_m2 = if yields > 0.0 { 1.0 / yields } else { HORN_KG_M2 };
            let speed_rad_s = self.own[servo].velocity_rad_s + dt_s * now[servo];
            let faster_rad_s = speed_rad_s - foreseen[servo].velocity_rad_s;
            let push = pushes[servo];
            let pushed_nm = push.torque_nm - push.slope_nm_s * faster_rad_s;
            self.loads[servo] = Arm {
                inertia_kg_m2,
                torque_nm: if yields > 0.0 { inertia_kg_m2 * now[servo] - pushed_nm } else { 0.0 },
                ..Arm::default()
            };
        }
    }
}

/// Speeds of the ways for a unit of speed of one dof or shaft.
fn along(list: &[Vec<(usize, f64)>], at: usize) -> Vec<f64> {
    let own = |way: &Vec<(usize, f64)>| {
        way.iter().filter(|(place, _)| *place == at).map(|(_, speed)| speed).sum()
    };
    list.iter().map(own).collect()
}

/// What a stop pushes with, and how that falls with speed; none if it does not. It does not pull back what leaves it.
fn stop(
    dt_s: f64,
    stiffness: f64,
    [least, most]: [f64; 2],
    at: f64,
    speed: f64,
) -> Option<(f64, f64)> {
    let beyond = at - at.clamp(least, most);
    let slope = stiffness * (STOP_DAMPING_S + dt_s);
    let force = -stiffness * beyond - slope * speed;
    (force * beyond < 0.0).then_some((force, slope))
}

impl Plant for RigPlant {
    type Load = Arm;

    fn load(&self, servo: usize) -> Arm {
        self.loads.get(servo).copied().unwrap_or_default()
    }

    /// With each step of the servos.
    fn servo_steps(&self) -> u32 {
        1
    }

    fn step(&mut self, dt_s: f64, pushes: &[Push], shafts: &mut [Shaft]) {
        self.mechanics.set(&self.q, &self.qd);
        let accelerations = self.accelerate(dt_s, pushes, shafts);
        for (speed, acceleration) in self.speeds.iter_mut().zip(&accelerations) {
            *speed += dt_s * acceleration;
        }
        self.qd.fill(0.0);
        for shaft in &mut self.own {
            shaft.velocity_rad_s = 0.0;
        }
        for (way, speed) in self.speeds.iter().enumerate() {
            for (dof, share) in &self.joints[way] {
                self.qd[*dof] += share * speed;
            }
            for (servo, share) in &self.shafts[way] {
                self.own[*servo].velocity_rad_s += share * speed;
            }
        }
        advance(&self.mechanics, &mut self.q, &self.qd, dt_s);
        for shaft in &mut self.own {
            shaft.position_rad += dt_s * shaft.velocity_rad_s;
        }
        for drive in 0..self.drives.len() {
            if !self.drives[drive].is_linear() {
                // Numbers of a pose that has run are finite: a drive takes them.
                let _ = self.take_ways(drive).and_then(|()| self.take_positions(drive));
            }
        }
        shafts.copy_from_slice(&self.own);
    }
}

#[cfg(test)]
mod tests;
