//! A whole rig on the shafts of its servos: servos affect each other, and gravity depends on the pose.
//!
//! The speeds of all joints after a step are the solution of one linear system. It is implicit in frictions, stops
//! and gears, and therefore stable for any stiffness. The gears belong to the servos. A servo solves its own step
//! before the rig moves, so it must predict its shaft. It assumes the acceleration of the last step, and that its
//! own torque changes this acceleration by `1 / Σ |W|` over the row of `W = B M⁻¹ Bᵀ`, which gives the shafts'
//! accelerations for torques on all shafts. The prediction decides whether teeth touch and which ends friction holds.
//! Then the rig moves with the torque of each gear as a linear function of its shaft's speed ([`Push`]), and shaft and
//! rotor take the speeds of the common solution. Torques that follow from the predicted shafts alone would be explicit:
//! light bodies on stiff gears would then diverge. At rest the predicted shaft is the real one, so friction holds a
//! joint in place. A force that begins to push moves a joint for some steps, until the servos react.

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
use crate::rig::{HORN_KG_M2, RigServosError, kind};
use drives::Driven;
pub use hand::Hand;
use hand::{Grip, Holds};
use mechanics::{Mechanics, advance};
use symmetric::Symmetric;

/// Speed below which the Coulomb friction of joints is proportional to speed, rad/s or m/s. Under a load, a joint
/// therefore creeps instead of resting.
const CREEP: f64 = 1e-3;
/// Minimum inertia of a joint without a servo, kg m² or kg: without inertia a joint could not follow a force.
const LEAST_INERTIA: f64 = 1e-6;
/// Smallest pivot when a matrix is factored. A smaller pivot is set to this value.
const LEAST_PIVOT: f64 = 1e-15;

/// A rig that is moved by the servos of one bench.
///
/// The base is fixed. If not all servos of a drive are on the bench, its joints stay at home. Joints without a servo
/// swing, with the friction in the rig's file. Not simulated: limits that couple two joints, ranges of ball joints, and
/// stiction of joints (servos have their own).
#[derive(Debug, Clone)]
pub struct RigPlant {
    mechanics: Mechanics,
    q: Vec<f64>,
    qd: Vec<f64>,
    drives: Vec<Driven>,
    /// For each independent motion: the dofs that it moves, and their speeds if the motion has speed 1.
    joints: Vec<Vec<(usize, f64)>>,
    /// For each independent motion: the servos that it turns, and their speeds if the motion has speed 1.
    shafts: Vec<Vec<(usize, f64)>>,
    /// Indices of each drive's independent motions.
    places: Vec<Range<usize>>,
    speeds: Vec<f64>,
    /// Inertia of each independent motion in addition to that of the bodies.
    extra: Vec<f64>,
    /// Friction of each dof.
    frictions: Vec<Friction>,
    ends: Vec<End>,
    hands: Vec<Holds>,
    /// External effort on each dof, N m or N.
    pushes: Vec<f64>,
    /// Minimum and maximum own position of each servo, rad.
    stops_rad: Vec<[f64; 2]>,
    own: Vec<Shaft>,
    loads: Vec<Arm>,
    /// Inertias of the independent motions, with frictions and stops; [`Self::coupled`] also contains the gears.
    matrix: Symmetric,
    coupled: Symmetric,
}

#[derive(Debug, Clone, Copy, Default)]
struct Friction {
    coulomb: f64,
    viscous: f64,
}

/// The range of a dof, with its stops.
#[derive(Debug, Clone, Copy)]
struct End {
    dof: usize,
    coordinate: usize,
    range: [f64; 2],
    stiffness: f64,
}

impl RigPlant {
    /// Creates a rig at rest at its home pose. `servos` are the names of the servos on the bench, in their order.
    ///
    /// # Errors
    /// [`RigServosError`], also if a name is not the name of a servo.
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
            // `actuation` has already refused unknown models.
            let Some(model) = description.servo_model(&described.model) else { continue };
            let middle = 0.5 * kind(description, described, &model)?.range_rad;
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

    /// Step of the plant, s, equal to that of the servos.
    const STEP_S: f64 = crate::device::STEP_S;

    /// Adds friction and stops of a joint. If no servo moves the joint, each of its dofs becomes an independent motion.
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

    /// Updates the independent motions of a drive at the present pose.
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

    /// Updates the positions of a drive's servos from the joints.
    fn take_positions(&mut self, drive: usize) -> Result<(), DriveInputError> {
        let of = &self.drives[drive];
        for (servo, position_rad) in of.servos.iter().zip(of.positions_rad(&of.at(&self.q)?)) {
            self.own[*servo].position_rad = position_rad;
        }
        Ok(())
    }

    /// Sets the additional inertia of each motion. With it, no motion has less inertia at home than a horn on each of
    /// its servos. A joint without servos gets the inertia of its rotor, and at least [`LEAST_INERTIA`] in total.
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

    /// Returns an element of the mass matrix of the independent motions.
    fn inertia(&self, one: usize, other: usize) -> f64 {
        let mut sum = 0.0;
        for (row, speed) in &self.joints[one] {
            for (column, other_speed) in &self.joints[other] {
                sum += speed * other_speed * self.mechanics.mass(*row, *column);
            }
        }
        sum
    }

    /// Makes a hand guide a dof; `None` releases it. Returns whether a hand can guide this dof: hands cannot guide ball
    /// joints and the free base.
    pub fn lead(&mut self, dof: usize, hand: Option<Hand>) -> bool {
        self.hands.retain(|holds| holds.grip.dof != dof);
        let Some(grip) = Grip::new(&self.mechanics, dof) else { return false };
        self.hands.extend(hand.map(|hand| Holds { grip, hand }));
        true
    }

    /// Applies an external torque, N m, or for a slide a force, N, to a dof, until the next call for this dof. Returns
    /// whether the dof exists.
    pub fn push(&mut self, dof: usize, torque_nm: f64) -> bool {
        let Some(push) = self.pushes.get_mut(dof) else { return false };
        *push = torque_nm;
        true
    }

    /// Returns the joint coordinates, in the order of `sinew_core::coordinates`.
    pub fn q(&self) -> &[f64] {
        &self.q
    }

    /// Returns the speeds of the dofs, rad/s and m/s.
    pub fn qd(&self) -> &[f64] {
        &self.qd
    }

    /// Returns kinetic plus potential energy, without rotors and horns, J.
    pub fn energy_j(&mut self) -> f64 {
        self.mechanics.set(&self.q, &self.qd);
        self.mechanics.energy_j()
    }

    /// Returns the accelerations of the motions over a step. Also computes the loads of the servos for the next step.
    /// `foreseen` are the shafts as the servos predicted them.
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

    /// Adds frictions and stops implicitly.
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

    /// Computes the load of each servo for the next step: see [the module](self).
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
            // A servo that moves no part of the rig moves only its horn.
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

/// Returns, for each independent motion, the speed of one dof or shaft per speed of the motion.
fn along(list: &[Vec<(usize, f64)>], at: usize) -> Vec<f64> {
    let own = |way: &Vec<(usize, f64)>| {
        way.iter().filter(|(place, _)| *place == at).map(|(_, speed)| speed).sum()
    };
    list.iter().map(own).collect()
}

/// Returns the force of a stop, and the decrease of the force per unit of speed. Returns `None` if the stop does not
/// push; it never pulls.
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

    /// The plant moves with each step of the servos.
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
                // The numbers of a simulated pose are finite, so the drive accepts them.
                let _ = self.take_ways(drive).and_then(|()| self.take_positions(drive));
            }
        }
        shafts.copy_from_slice(&self.own);
    }
}

#[cfg(test)]
mod tests;
