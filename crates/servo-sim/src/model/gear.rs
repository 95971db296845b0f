//! Rotor, gear with friction and play, and output shaft.

use super::Parameters;
use super::motor::Characteristic;
use crate::load::{Load, Push, Shaft};

/// Torques and power losses of a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// Torque of the motor before friction, N m.
    pub motor_nm: f64,
    /// Torque of the shaft on its load, N m: the gear's torque minus the friction at the shaft.
    pub shaft_nm: f64,
    /// Power lost by friction and by the gear's own damping, W.
    pub friction_w: f64,
}

/// Two masses with play between them: the rotor, as seen at the output, and the load on the shaft.
///
/// Dry friction consists of Coulomb friction, its Stribeck rise at rest, and a part proportional to the torques of
/// motor and shaft (Rhoban/bam, models m1 to m4; their Stribeck exponent is 2 here). It acts on both ends: one
/// share acts on the shaft and depends on the shaft's speed; the rest acts on the rotor and depends on the rotor's
/// speed. Viscous friction acts only on the rotor.
///
/// A step is implicit Euler in the speeds. Friction at rest is exact at both ends: an end stays at rest as long as
/// its friction can hold it. The step is therefore stable for any stiffness, and can only remove energy.
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
    link_damping_nm_s: f64,
    output_share: f64,
    /// State of the rotor, as seen at the output.
    pub rotor: Shaft,
    /// State of the output shaft.
    pub shaft: Shaft,
    /// Whether the gear is blocked.
    pub is_jammed: bool,
    flow: Flow,
    coupling: Coupling,
}

impl Gear {
    /// Creates a gear at rest.
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
            link_damping_nm_s: parameters.gear_damping_nm_s,
            output_share: parameters.output_friction_share,
            rotor: Shaft::default(),
            shaft: Shaft::default(),
            is_jammed: false,
            flow: Flow::default(),
            coupling: Coupling::default(),
        }
    }

    /// Returns the torques and losses of the last step.
    pub fn flow(&self) -> Flow {
        self.flow
    }

    /// Returns the push on the shaft in the last step.
    pub fn push(&self) -> Push {
        Push { torque_nm: self.flow.shaft_nm, slope_nm_s: self.coupling.slope_nm_s }
    }

    /// Sets the shaft to its state in the plant after a step, and corrects the rotor and the torque accordingly:
    /// this is the linear part of [`Self::step`], solved for the real speed of the shaft.
    pub(crate) fn lead(&mut self, dt_s: f64, shaft: Shaft) {
        let faster_rad_s = shaft.velocity_rad_s - self.shaft.velocity_rad_s;
        let rotor_rad_s = self.coupling.rotor_share * faster_rad_s;
        self.rotor.velocity_rad_s += rotor_rad_s;
        self.rotor.position_rad += dt_s * rotor_rad_s;
        self.flow.shaft_nm -= self.coupling.slope_nm_s * faster_rad_s;
        self.shaft = shaft;
    }

    /// Places shaft and rotor at a position, rad, at rest.
    pub fn place(&mut self, position_rad: f64) {
        self.shaft = Shaft { position_rad, velocity_rad_s: 0.0 };
        self.rotor = self.shaft;
    }

    /// Returns the kinetic energy plus the energy of the wound-up gear, J, for a load with this inertia.
    pub fn energy_j(&self, load_kg_m2: f64) -> f64 {
        let [rotor, shaft] = [self.rotor.velocity_rad_s, self.shaft.velocity_rad_s];
        let windup = self.windup_rad();
        0.5 * (self.inertia_kg_m2 * rotor * rotor
            + load_kg_m2 * shaft * shaft
            + self.stiffness_nm_rad * windup * windup)
    }

    /// Returns the windup of the gear beyond its play, rad.
    fn windup_rad(&self) -> f64 {
        let twist = self.rotor.position_rad - self.shaft.position_rad;
        twist - twist.clamp(-self.half_play_rad, self.half_play_rad)
    }

    /// Returns the maximum friction torque at the rotor and at the shaft, N m.
    fn most_friction_nm(&self) -> [f64; 2] {
        let load_nm = self.flow.motor_nm.abs() + self.flow.shaft_nm.abs();
        let at = |end: Shaft| {
            let rise = if self.stribeck_nm > 0.0 {
                let ratio = end.velocity_rad_s / self.stribeck_rad_s;
                self.stribeck_nm * libm::exp(-ratio * ratio)
            } else {
                0.0
            };
            self.friction_nm + rise + self.load_friction * load_nm
        };
        let rotor_nm =
            if self.is_jammed { f64::INFINITY } else { (1.0 - self.output_share) * at(self.rotor) };
        [rotor_nm, self.output_share * at(self.shaft)]
    }

    /// Advances under a constant motor torque, N m, independent of the speed: for a gear without a servo.
    pub fn step_under(&mut self, dt_s: f64, motor_nm: f64, load: &impl Load) {
        self.step(dt_s, Characteristic { nm: motor_nm, nm_s: 0.0 }, load);
    }

    pub(crate) fn step(&mut self, dt_s: f64, motor: Characteristic, load: &impl Load) {
        let load_kg_m2 = load.inertia_kg_m2();
        let outer_nm = load.torque_nm(self.shaft);
        let windup = self.windup_rad();
        let after = if windup == 0.0 {
            self.solve(dt_s, motor, (load_kg_m2, outer_nm), windup)
        } else {
            let touching = self.solve(dt_s, motor, (load_kg_m2, outer_nm), windup);
            // Teeth can push, but not pull.
            if touching.gear_nm * windup >= 0.0 {
                touching
            } else {
                self.solve(dt_s, motor, (load_kg_m2, outer_nm), 0.0)
            }
        };
        let After { speeds_rad_s: [rotor, shaft], gear_nm, frictions_nm, coupling } = after;
        self.coupling = coupling;
        let rubbing_w = (frictions_nm[0] + self.damping_nm_s * rotor) * rotor;
        let stored_w = self.stiffness_nm_rad * windup * (rotor - shaft);
        self.flow = Flow {
            motor_nm: motor.nm - motor.nm_s * rotor,
            shaft_nm: gear_nm - frictions_nm[1],
            friction_w: rubbing_w + frictions_nm[1] * shaft + gear_nm * (rotor - shaft) - stored_w,
        };
        self.rotor.velocity_rad_s = rotor;
        self.rotor.position_rad += dt_s * rotor;
        self.shaft.velocity_rad_s = shaft;
        self.shaft.position_rad += dt_s * shaft;
    }

    /// Solves one step. The ends are linked unless the windup is zero.
    ///
    /// The step is h. The unknowns are the new speeds r and q of rotor and shaft; r0 and q0 are the old speeds, Jr and
    /// Jl the inertias. The motor's torque is m - s r; b is the viscous damping, u the windup, K the stiffness, c the
    /// link, e the load's torque. Then (Jr/h + s + b + c) r - c q = Jr/h r0 + m - K u - f and (Jl/h + c) q - c r = Jl/h
    /// q0 + K u + e - g, where K u + c (r - q) is the gear's torque. The frictions f and g stop the ends if they
    /// can; otherwise they oppose the motion of the ends. The matrix is positive definite, so there is exactly one
    /// solution: the shaft turns forwards, backwards, or rests.
    fn solve(
        &self,
        dt_s: f64,
        motor: Characteristic,
        (load_kg_m2, outer_nm): (f64, f64),
        windup_rad: f64,
    ) -> After {
        let spring_nm = self.stiffness_nm_rad * windup_rad;
        let link = if windup_rad == 0.0 {
            0.0
        } else {
            self.stiffness_nm_rad * dt_s + self.link_damping_nm_s
        };
        let rotor_h = self.inertia_kg_m2 / dt_s;
        let load_h = load_kg_m2 / dt_s;
        let a = rotor_h + motor.nm_s + self.damping_nm_s + link;
        let b = load_h + link;
        let to_rotor = rotor_h * self.rotor.velocity_rad_s + motor.nm - spring_nm;
        let to_load = load_h * self.shaft.velocity_rad_s + spring_nm + outer_nm;
        let [most_rotor, most_shaft] = self.most_friction_nm();
        let after = |[rotor, shaft]: [f64; 2], frictions_nm: [f64; 2]| {
            // A rotor that friction holds stands still, however the shaft turns.
            let rotor_share = if frictions_nm[0].abs() < most_rotor { 0.0 } else { link / a };
            After {
                speeds_rad_s: [rotor, shaft],
                gear_nm: spring_nm + link * (rotor - shaft),
                frictions_nm,
                coupling: Coupling { rotor_share, slope_nm_s: link * (1.0 - rotor_share) },
            }
        };
        let turns = |friction_nm: f64| {
            let to_load = to_load - friction_nm;
            let determinant = a * b - link * link;
            let free = (to_rotor * b + link * to_load) / determinant;
            let per_friction = b / determinant;
            let at_rotor = (free / per_friction).clamp(-most_rotor, most_rotor);
            let rotor = free - at_rotor * per_friction;
            after([rotor, (to_load + link * rotor) / b], [at_rotor, friction_nm])
        };
        if most_shaft <= 0.0 {
            return turns(0.0);
        }
        for direction in [1.0, -1.0] {
            let turned = turns(direction * most_shaft);
            if direction * turned.speeds_rad_s[1] > 0.0 {
                return turned;
            }
        }
        let at_rotor = to_rotor.clamp(-most_rotor, most_rotor);
        let rotor = (to_rotor - at_rotor) / a;
        let at_shaft = (to_load + link * rotor).clamp(-most_shaft, most_shaft);
        after([rotor, 0.0], [at_rotor, at_shaft])
    }
}

/// Response of the gear to a shaft that turns faster than predicted, in a step.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
struct Coupling {
    /// Additional speed of the rotor for each additional rad/s of the shaft.
    rotor_share: f64,
    /// Decrease of the torque on the shaft for each additional rad/s of the shaft, N m s/rad.
    slope_nm_s: f64,
}

/// State of both ends after a step.
struct After {
    /// Speeds of rotor and shaft, rad/s.
    speeds_rad_s: [f64; 2],
    /// Torque of the gear on the shaft, N m.
    gear_nm: f64,
    /// Dry friction at rotor and shaft, N m.
    frictions_nm: [f64; 2],
    coupling: Coupling,
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::Arm;

    const STEP_S: f64 = 2.5e-4;
    const IDLE: Characteristic = Characteristic { nm: 0.0, nm_s: 0.0 };

    fn kind(name: &str, output_friction_share: f64) -> Parameters {
        let kind = Parameters::built_in(name).expect("it is built in");
        Parameters { output_friction_share, ..kind }
    }

    #[test]
    fn a_free_gear_loses_energy_and_comes_to_rest() {
        for share in [0.0, 0.3, 0.7, 1.0] {
            let mut gear = Gear::new(&kind("XL330-M288-T", share));
            let arm = Arm { inertia_kg_m2: 1e-3, ..Arm::default() };
            gear.rotor.velocity_rad_s = 5.0;
            let mut before = gear.energy_j(arm.inertia_kg_m2);
            for _ in 0..40_000 {
                gear.step(STEP_S, IDLE, &arm);
                let now = gear.energy_j(arm.inertia_kg_m2);
                // A windup that begins within a step is noticed only after the step: at most half a step's motion
                // too late.
                assert!(now <= before + 1e-3, "{share}: {before} J became {now} J");
                before = now;
            }
            // Within the play, an end without dry friction is not stopped.
            assert!(share <= 0.0 || gear.shaft.velocity_rad_s.abs() < 1e-12, "{share}");
            assert!(share >= 1.0 || gear.rotor.velocity_rad_s.abs() < 1e-12, "{share}");
        }
    }

    /// Random shares, loads and motions: friction never exceeds its maximum, and never adds energy.
    #[test]
    fn friction_takes_energy_at_both_ends() {
        let mut random = crate::random::Random::new(36);
        for _ in 0..200 {
            let mut gear = Gear::new(&kind("STS3215-7.4V", random.between(0.0, 1.0)));
            let arm = Arm { inertia_kg_m2: random.between(1e-4, 1e-1), ..Arm::default() };
            gear.rotor.velocity_rad_s = random.between(-5.0, 5.0);
            gear.shaft.velocity_rad_s = random.between(-5.0, 5.0);
            for _ in 0..400 {
                let motor = Characteristic { nm: random.between(-1.0, 1.0), nm_s: 0.1 };
                let windup = gear.windup_rad();
                let load = (arm.inertia_kg_m2, 0.0);
                let after = gear.solve(STEP_S, motor, load, windup);
                let ends = after.speeds_rad_s.into_iter().zip(after.frictions_nm);
                for ((speed, friction), most) in ends.zip(gear.most_friction_nm()) {
                    // The speed of an end at rest is a rounding error.
                    assert!(friction * speed > -1e-12 && friction.abs() <= most);
                    // An end slides at full friction, or rests.
                    let lacks = most - friction.abs();
                    assert!(lacks.abs() < 1e-12 || speed.abs() < 1e-12, "{speed} {lacks}");
                }
                gear.step(STEP_S, motor, &arm);
                assert!(gear.flow.friction_w > -1e-9, "{} W", gear.flow.friction_w);
            }
        }
    }

    /// Computes a step with a simpler model, which has friction only at the rotor.
    fn step_with_friction_at_the_rotor(
        gear: &Gear,
        motor: Characteristic,
        load_kg_m2: f64,
    ) -> [f64; 2] {
        let windup = gear.windup_rad();
        let solve = |windup: f64, link: f64| {
            let spring_nm = gear.stiffness_nm_rad * windup;
            let a = gear.inertia_kg_m2 / STEP_S + motor.nm_s + gear.damping_nm_s + link;
            let b = load_kg_m2 / STEP_S + link;
            let to_rotor =
                gear.inertia_kg_m2 / STEP_S * gear.rotor.velocity_rad_s + motor.nm - spring_nm;
            let to_load = load_kg_m2 / STEP_S * gear.shaft.velocity_rad_s + spring_nm;
            let determinant = a * b - link * link;
            let free = (to_rotor * b + link * to_load) / determinant;
            let ratio = gear.rotor.velocity_rad_s / gear.stribeck_rad_s;
            let most = gear.friction_nm
                + gear.stribeck_nm * libm::exp(-ratio * ratio)
                + gear.load_friction * (gear.flow.motor_nm.abs() + gear.flow.shaft_nm.abs());
            let friction = (free * determinant / b).clamp(-most, most);
            let rotor = free - friction * b / determinant;
            let shaft = (to_load + link * rotor) / b;
            ([rotor, shaft], spring_nm + link * (rotor - shaft))
        };
        let link = if windup == 0.0 {
            0.0
        } else {
            gear.stiffness_nm_rad * STEP_S + gear.link_damping_nm_s
        };
        let (speeds, gear_nm) = solve(windup, link);
        if gear_nm * windup >= 0.0 { speeds } else { solve(0.0, 0.0).0 }
    }

    #[test]
    fn with_all_friction_at_the_rotor_a_step_is_what_it_was() {
        let mut random = crate::random::Random::new(7);
        for name in ["XL330-M288-T", "MX-64"] {
            let mut gear = Gear::new(&kind(name, 0.0));
            let arm = Arm { inertia_kg_m2: 1e-3, ..Arm::default() };
            for _ in 0..4_000 {
                let motor = Characteristic { nm: random.between(-0.5, 0.5), nm_s: 0.02 };
                let expected = step_with_friction_at_the_rotor(&gear, motor, arm.inertia_kg_m2);
                gear.step(STEP_S, motor, &arm);
                let speeds = [gear.rotor.velocity_rad_s, gear.shaft.velocity_rad_s];
                for (speed, expected) in speeds.into_iter().zip(expected) {
                    // The sums have another order; speeds are some rad/s.
                    assert!((speed - expected).abs() < 1e-12, "{name}: {speed} {expected}");
                }
            }
        }
    }

    #[test]
    fn friction_at_the_shaft_holds_it_until_it_cannot() {
        let kind = kind("XL330-M288-T", 0.3);
        let most_nm = 0.3 * (kind.friction_nm + kind.stribeck_nm);
        for sign in [1.0, -1.0] {
            let pushed = |torque_nm: f64| {
                let mut gear = Gear::new(&kind);
                for _ in 0..4_000 {
                    gear.step(STEP_S, IDLE, &Arm { torque_nm: sign * torque_nm, ..Arm::default() });
                }
                gear.shaft.position_rad
            };
            let at_rest = pushed(0.99 * most_nm);
            assert!(at_rest.abs() < 1e-15, "{at_rest}");
            // The pushing torque is itself a load, which adds load friction.
            let moved = pushed(1.01 * most_nm / (1.0 - 0.3 * kind.load_friction));
            assert!(sign * moved > 0.4 * kind.backlash_rad, "{moved}");
        }
    }

    #[test]
    fn a_jammed_gear_does_not_move() {
        let parameters = Parameters::built_in("STS3215-7.4V").expect("it is built in");
        let mut gear = Gear::new(&parameters);
        gear.is_jammed = true;
        for _ in 0..1_000 {
            gear.step(STEP_S, Characteristic { nm: 2.0, nm_s: 0.1 }, &Arm::default());
        }
        assert!(gear.shaft.position_rad.abs() < 1e-9);
    }
}
