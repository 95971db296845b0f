//! Rotor, gear with friction and play, and the shaft.

use super::Parameters;
use super::motor::Characteristic;
use crate::load::{Load, Shaft};

/// Part of the critical damping that a gear has between its ends.
const GEAR_DAMPING: f64 = 0.3;

/// Where torque and power went in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// Torque of the motor, before friction, N m.
    pub motor_nm: f64,
    /// Torque of the gear on the shaft, N m.
    pub shaft_nm: f64,
    /// Power lost by friction and in the gear's own damping, W.
    pub friction_w: f64,
}

/// Two masses with play between them: the rotor, as the gear shows it at the output, and what hangs on the shaft.
///
/// Friction acts on the rotor: Coulomb with a Stribeck rise at rest, viscous, and in proportion to the torques of the
/// motor and of the shaft (Rhoban/bam, models m1 to m4; their Stribeck exponent is 2 here).
///
/// A step is implicit Euler in the speeds, with friction at rest exact: it holds as long as it can. So it is stable for
/// any stiffness, and takes energy out, never in.
#[derive(Debug, Clone, PartialEq)]
pub struct Gear {
    inertia_kg_m2: f64,
    friction_nm: f64,
    stribeck_nm: f64,
    stribeck_rad_s: f64,
    load_friction: f64,
    damping_nm_s: f64,
    half_play_rad: f64,
    stiffness_nm_rad: f64,
    /// The rotor, at the output.
    pub rotor: Shaft,
    /// The output shaft.
    pub shaft: Shaft,
    /// Whether something blocks the gear.
    pub is_jammed: bool,
    flow: Flow,
}

impl Gear {
    /// A gear at rest.
    pub fn new(parameters: &Parameters) -> Self {
        Self {
            inertia_kg_m2: parameters.rotor_inertia_kg_m2,
            friction_nm: parameters.friction_nm,
            stribeck_nm: parameters.stribeck_nm,
            stribeck_rad_s: parameters.stribeck_rad_s,
            load_friction: parameters.load_friction,
            damping_nm_s: parameters.damping_nm_s,
            half_play_rad: 0.5 * parameters.backlash_rad,
            stiffness_nm_rad: parameters.gear_stiffness_nm_rad,
            rotor: Shaft::default(),
            shaft: Shaft::default(),
            is_jammed: false,
            flow: Flow::default(),
        }
    }

    /// What came out of the last step.
    pub fn flow(&self) -> Flow {
        self.flow
    }

    /// Puts the shaft, and the rotor with it, somewhere at rest; rad.
    pub fn place(&mut self, position_rad: f64) {
        self.shaft = Shaft { position_rad, velocity_rad_s: 0.0 };
        self.rotor = self.shaft;
    }

    /// Energy of motion and of the wound-up gear, with a load of this inertia; J.
    pub fn energy_j(&self, load_kg_m2: f64) -> f64 {
        let [rotor, shaft] = [self.rotor.velocity_rad_s, self.shaft.velocity_rad_s];
        let windup = self.windup_rad();
        0.5 * (self.inertia_kg_m2 * rotor * rotor
            + load_kg_m2 * shaft * shaft
            + self.stiffness_nm_rad * windup * windup)
    }

    /// How far the gear is wound up, beyond its play, rad.
    fn windup_rad(&self) -> f64 {
        let twist = self.rotor.position_rad - self.shaft.position_rad;
        twist - twist.clamp(-self.half_play_rad, self.half_play_rad)
    }

    /// The most that friction takes, N m.
    fn most_friction_nm(&self) -> f64 {
        if self.is_jammed {
            return f64::INFINITY;
        }
        let rise = if self.stribeck_nm > 0.0 {
            let ratio = self.rotor.velocity_rad_s / self.stribeck_rad_s;
            self.stribeck_nm * libm::exp(-ratio * ratio)
        } else {
            0.0
        };
        let load_nm = self.flow.motor_nm.abs() + self.flow.shaft_nm.abs();
        self.friction_nm + rise + self.load_friction * load_nm
    }

    pub(crate) fn step(&mut self, dt_s: f64, motor: Characteristic, load: &impl Load) {
        let load_kg_m2 = load.inertia_kg_m2();
        let outer_nm = load.torque_nm(self.shaft);
        let windup = self.windup_rad();
        let (rotor, shaft, gear_nm, friction_nm) = if windup == 0.0 {
            self.solve(dt_s, motor, (load_kg_m2, outer_nm), windup, 0.0)
        } else {
            let both = self.inertia_kg_m2 * load_kg_m2 / (self.inertia_kg_m2 + load_kg_m2);
            let damping = 2.0 * GEAR_DAMPING * libm::sqrt(self.stiffness_nm_rad * both);
            let touching = self.solve(dt_s, motor, (load_kg_m2, outer_nm), windup, damping);
            // Teeth push; they do not pull.
            if touching.2 * windup >= 0.0 {
                touching
            } else {
                self.solve(dt_s, motor, (load_kg_m2, outer_nm), 0.0, 0.0)
            }
        };
        let motor_nm = motor.nm - motor.nm_s * rotor;
        let rubbing_w = (friction_nm + self.damping_nm_s * rotor) * rotor;
        let stored_w = self.stiffness_nm_rad * windup * (rotor - shaft);
        self.flow = Flow {
            motor_nm,
            shaft_nm: gear_nm,
            friction_w: rubbing_w + gear_nm * (rotor - shaft) - stored_w,
        };
        self.rotor.velocity_rad_s = rotor;
        self.rotor.position_rad += dt_s * rotor;
        self.shaft.velocity_rad_s = shaft;
        self.shaft.position_rad += dt_s * shaft;
    }

    /// Both speeds after a step, the torque between the ends, and that of dry friction.
    ///
    /// With h the step: (Jr/h + s + b + c) r - c q = Jr/h r0 + m - K u - f and (Jl/h + c) q - c r = Jl/h q0 + K u + e,
    /// where K u + c (r - q) is the gear's torque, and f stops the rotor if it can.
    fn solve(
        &self,
        dt_s: f64,
        motor: Characteristic,
        (load_kg_m2, outer_nm): (f64, f64),
        windup_rad: f64,
        damping_nm_s: f64,
    ) -> (f64, f64, f64, f64) {
        let spring_nm = self.stiffness_nm_rad * windup_rad;
        let link =
            if windup_rad == 0.0 { 0.0 } else { self.stiffness_nm_rad * dt_s + damping_nm_s };
        let rotor_h = self.inertia_kg_m2 / dt_s;
        let load_h = load_kg_m2 / dt_s;
        let a = rotor_h + motor.nm_s + self.damping_nm_s + link;
        let b = load_h + link;
        let to_rotor = rotor_h * self.rotor.velocity_rad_s + motor.nm - spring_nm;
        let to_load = load_h * self.shaft.velocity_rad_s + spring_nm + outer_nm;
        let determinant = a * b - link * link;
        let free = (to_rotor * b + link * to_load) / determinant;
        let per_friction = b / determinant;
        let most = self.most_friction_nm();
        let friction_nm = (free / per_friction).clamp(-most, most);
        let rotor = free - friction_nm * per_friction;
        let shaft = (to_load + link * rotor) / b;
        (rotor, shaft, spring_nm + link * (rotor - shaft), friction_nm)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Arm;

    #[test]
    fn a_free_gear_loses_energy_and_comes_to_rest() {
        let parameters = Parameters::built_in("XL330-M288-T").expect("it is built in");
        let mut gear = Gear::new(&parameters);
        let arm = Arm { inertia_kg_m2: 1e-3, ..Arm::default() };
        gear.rotor.velocity_rad_s = 5.0;
        let idle = Characteristic { nm: 0.0, nm_s: 0.0 };
        let mut before = gear.energy_j(arm.inertia_kg_m2);
        for _ in 0..40_000 {
            gear.step(2.5e-4, idle, &arm);
            let now = gear.energy_j(arm.inertia_kg_m2);
            // A windup that begins within a step is seen after it: at most half a step's travel too late.
            assert!(now <= before + 1e-3, "{before} J became {now} J");
            before = now;
        }
        assert!(gear.rotor.velocity_rad_s.abs() < 1e-12);
    }

    #[test]
    fn a_jammed_gear_does_not_move() {
        let parameters = Parameters::built_in("STS3215-7.4V").expect("it is built in");
        let mut gear = Gear::new(&parameters);
        gear.is_jammed = true;
        for _ in 0..1_000 {
            gear.step(2.5e-4, Characteristic { nm: 2.0, nm_s: 0.1 }, &Arm::default());
        }
        assert!(gear.shaft.position_rad.abs() < 1e-9);
    }
}
