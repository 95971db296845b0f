//! Simulated servos that hold a pose over their bus, with and without the offset.

use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{Condition, DriveSettings, Drives, PositionSettings};
use sinew_servo_bus::dynamixel;
use sinew_servo_bus::dynamixel::table::{MODELS, address};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{Command, Schedule, ServoBus, Timing as BusTiming};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::{Load, Plant, Push, Shaft};
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

use super::figure::{Figure, Weights};

const BAUD: u32 = 1_000_000;
const TICK_US: u32 = 10_000;
const RATE_HZ: u32 = 100;
/// Ticks until the rig rests: the movement takes at most 1 s, the offset 0.35 s.
const TICKS: u32 = 250;
/// Number of last ticks over which positions are averaged: within the play of its gear, a shaft without load moves to
/// and fro.
const MEAN_TICKS: u32 = 50;
/// Maximum difference between the means of a shaft at rest: the play of an STS3215, which has the largest.
const REST_RAD: f64 = 0.0175;
const MOST_SERVOS: usize = 8;

/// Ratios of properties of the rig as built to those of its model.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AsBuilt {
    pub(crate) masses: f64,
    pub(crate) friction: f64,
    pub(crate) stiffness: f64,
}

impl AsBuilt {
    pub(crate) const TRUE: Self = Self { masses: 1.0, friction: 1.0, stiffness: 1.0 };

    /// Returns the parameters of the servos as built.
    pub(crate) fn kind(self, model: &str) -> Parameters {
        let mut kind = Parameters::built_in(model).unwrap();
        kind.friction_nm *= self.friction;
        kind.stribeck_nm *= self.friction;
        kind.load_friction *= self.friction;
        kind.position_gain_nm_rad *= self.stiffness;
        // A Dynamixel's stiffness follows from its gain.
        kind.position_p_divisor /= self.stiffness;
        kind
    }
}

/// Load of a held shaft: the weight at the pose of all joints, and the inertia.
#[derive(Clone, Copy)]
pub(crate) struct Held {
    inertia_kg_m2: f64,
    weight_nm: f64,
}

impl Load for Held {
    fn inertia_kg_m2(&self) -> f64 {
        self.inertia_kg_m2
    }

    fn torque_nm(&self, _: Shaft) -> f64 {
        -self.weight_nm
    }
}

/// A rig at rest. Gravity is that of the current pose; forces between moving joints are left out.
struct AtRest<'f> {
    figure: &'f Figure,
    weights: Weights,
    q: Vec<f32>,
    held: Vec<Held>,
}

impl Plant for AtRest<'_> {
    type Load = Held;

    fn load(&self, servo: usize) -> Held {
        self.held[servo]
    }

    fn step(&mut self, _: f64, _: &[Push], shafts: &mut [Shaft]) {
        for (place, shaft) in self.figure.places.iter().zip(shafts) {
            self.q[*place] = (shaft.position_rad - std::f64::consts::PI) as f32;
        }
        let weights = self.weights.at(&self.q);
        for (held, weight_nm) in self.held.iter_mut().zip(weights) {
            held.weight_nm = weight_nm.into();
        }
    }
}

/// A joint at rest.
#[derive(Debug, Clone, Copy)]
#[expect(clippy::struct_field_names, reason = "the house's names have their units")]
pub(crate) struct Rest {
    /// Distance of the joint from its target, rad.
    pub(crate) error_rad: f64,
    /// Distance from the target without friction and steps, rad: the offset of the goal by the rig's model, minus the
    /// deflection of the rig as built.
    pub(crate) smooth_rad: f64,
    /// Maximum deviation that friction and the steps of encoder and goal can explain, rad.
    pub(crate) band_rad: f64,
}

/// Moves to a pose, holds it, and returns each joint at rest. `offset` is whether the drives compensate gravity
/// with the rig's model.
pub(crate) fn rests(figure: &Figure, built: AsBuilt, target: &[f64], offset: bool) -> Vec<Rest> {
    let is_feetech = figure.model.starts_with("STS");
    let kind = built.kind(&figure.model);
    let count = figure.places.len();
    let mut memory = vec![[0; MEMORY_LEN]; count];
    let servos = (1..).zip(&mut memory).map(|(id, memory)| {
        let mut servo = Servo::new(&kind, id, memory).unwrap();
        servo.set_baud(BAUD).unwrap();
        if !is_feetech {
            // Return delay is 2 us, and writes are not answered.
            servo.set(9, 1);
            servo.set(68, 1);
        }
        servo
    });
    let mut weights = figure.weights(built.masses);
    let inertias = weights.inertias(&figure.home).into_iter();
    let held = inertias.map(|inertia_kg_m2| Held { inertia_kg_m2, weight_nm: 0.0 }).collect();
    let plant = AtRest { figure, weights, q: figure.home.clone(), held };
    let mut bench = Bench::new(servos.collect(), plant, Supply::stiff(kind.voltage_v));
    let offset_rad = if offset { PositionSettings::default().offset_rad } else { 0.0 };
    let timing = BusTiming { baud: BAUD, return_delay_us: 2, turnaround_us: 5 };
    let servos = u32::try_from(count).unwrap();
    if is_feetech {
        let family = Family::Sts;
        let traffic = feetech::traffic(family, servos).with_goal(6);
        let schedule = Schedule::new(timing, &traffic, RATE_HZ).unwrap();
        let setup = |id| feetech::ServoSetup {
            id,
            mode: feetech::Mode::Position,
            range_rad: [0.0, 6.2],
            pwm: 1.0,
            speed_rad_s: 10.0,
        };
        let settings = feetech::Settings { family, echo: false, retries: 1, speed_counts: 1 };
        let setups: Vec<_> = (1..).take(count).map(setup).collect();
        let mut bus = feetech::Bus::<MOST_SERVOS>::new(&setups, schedule, settings).unwrap();
        let reached = hold(figure, &mut bus, &mut bench, target, offset_rad);
        // With the factory's settings the stiffness is that of the model.
        let stiffness = |_: &Servo<'_>| kind.position_gain_nm_rad;
        // Half a step of the goal, half a step of the encoder, and a dead zone of one step.
        rest(figure, &mut bench, (target, &reached), offset_rad, (&kind, 2.0, stiffness))
    } else {
        let schedule =
            Schedule::new(timing, &dynamixel::traffic(servos, 8, false), RATE_HZ).unwrap();
        let name = figure.model.trim_end_matches("-T");
        let setup = |id| dynamixel::ServoSetup {
            id,
            model: MODELS.iter().find(|model| model.name == name).unwrap(),
            mode: dynamixel::Mode::Position,
            range_rad: [0.0, 6.2],
            current_a: 1.0,
            pwm: 1.0,
            speed_rad_s: 15.0,
        };
        let setups: Vec<_> = (1..).take(count).map(setup).collect();
        let settings = dynamixel::Settings { fast: false, retries: 1 };
        let mut bus = dynamixel::Bus::<MOST_SERVOS>::new(&setups, schedule, settings).unwrap();
        let reached = hold(figure, &mut bus, &mut bench, target, offset_rad);
        // P gain divided by its divisor is the PWM per step; 885 is the whole supply.
        let motor_nm = kind.torque_constant_nm_a * kind.voltage_v / kind.resistance_ohm;
        let stiffness = |servo: &Servo<'_>| {
            let p = f64::from(servo.get(address::POSITION_P));
            p / kind.position_p_divisor / kind.resolution_rad / 885.0 * motor_nm
        };
        // Half a step of the goal, and half a step of the encoder.
        rest(figure, &mut bench, (target, &reached), offset_rad, (&kind, 1.0, stiffness))
    }
}

/// Computes how much of each joint's error friction and steps explain. `stiffness` is that of a cold servo, N m/rad.
fn rest(
    figure: &Figure,
    bench: &mut Bench<'_, AtRest<'_>>,
    (target, reached): (&[f64], &[f64]),
    offset_rad: f32,
    (kind, steps, stiffness): (&Parameters, f64, impl Fn(&Servo<'_>) -> f64),
) -> Vec<Rest> {
    let mut q = figure.home.clone();
    for (place, reached) in figure.places.iter().zip(reached) {
        q[*place] = *reached as f32;
    }
    let (modelled, held) = (figure.weights(1.0).at(&q), bench.plant.weights.at(&q));
    let limit = f64::from(offset_rad);
    let mut rests = Vec::new();
    for (index, servo) in bench.servos().iter().enumerate() {
        let (modelled, held) = (f64::from(modelled[index]), f64::from(held[index]));
        let (target, reached) = (target[index], reached[index]);
        let own = figure.board.servos()[index].servo.settings();
        let sag_rad = modelled / f64::from(own.position_gain_nm_rad);
        let [least, most] = own.range_rad.map(f64::from);
        let goal = (target + sag_rad.clamp(-limit, limit)).clamp(least, most);
        // A warm winding gives less torque.
        let stiffness = stiffness(servo) / servo.heat().resistance_ratio();
        // At rest, motor and weight differ at most by friction, which increases with both.
        let load = kind.load_friction;
        let dry_nm = kind.friction_nm + kind.stribeck_nm;
        let friction_nm = (dry_nm + 2.0 * load * held.abs()) / (1.0 - load);
        rests.push(Rest {
            error_rad: reached - target,
            smooth_rad: goal - target - held / stiffness,
            band_rad: friction_nm / stiffness + steps * kind.resolution_rad,
        });
    }
    rests
}

/// Returns the final position of each joint, rad.
fn hold(
    figure: &Figure,
    bus: &mut impl ServoBus,
    bench: &mut Bench<'_, AtRest<'_>>,
    target: &[f64],
    offset_rad: f32,
) -> Vec<f64> {
    let count = figure.places.len();
    let settings = PositionSettings { offset_rad, ..PositionSettings::default() };
    let timing = Timing { dt_s: 1e-6 * TICK_US as f32, latency_ticks: 1 };
    let settings = vec![DriveSettings::Position(settings); count];
    let mut drives = Drives::new(&figure.board, &settings, timing).unwrap();
    let mut model = figure.weights(1.0);
    let mut measured = vec![None; figure.home.len()];
    let mut commands = vec![DofCommand::default(); figure.home.len()];
    let mut out = vec![None; count];
    let mut means = [vec![0.0; count], vec![0.0; count]];
    for tick in 0..TICKS {
        let conditions: Vec<_> = (0..count).map(|servo| Condition::of(bus, servo)).collect();
        // Gravity by the model, at the measured pose.
        drives.measured(&conditions, &mut measured).unwrap();
        let q: Vec<f32> = figure
            .home
            .iter()
            .zip(&measured)
            .map(|(home, measured)| measured.map_or(*home, |measured| measured.position))
            .collect();
        let weights = model.at(&q);
        for ((place, target), weight) in figure.places.iter().zip(target).zip(weights) {
            commands[*place].position = *target as f32;
            commands[*place].feedforward_effort = weight;
        }
        if tick == 1 {
            drives.begin(&conditions);
            for servo in 0..count {
                bus.command(servo, Command::Torque(true)).unwrap();
            }
        }
        if tick > 0 {
            drives.step(&commands, &conditions, &mut out).unwrap();
            for (servo, command) in out.iter().enumerate() {
                bus.command(servo, command.unwrap().command).unwrap();
            }
        }
        bench.tick(bus, TICK_US).unwrap();
        if tick >= TICKS - 2 * MEAN_TICKS {
            let half = usize::from(tick >= TICKS - MEAN_TICKS);
            for (sum, servo) in means[half].iter_mut().zip(bench.servos()) {
                *sum += servo.shaft().position_rad / f64::from(MEAN_TICKS);
            }
        }
    }
    let [before, reached] = means;
    for (before, reached) in before.iter().zip(&reached) {
        assert!(
            (before - reached).abs() < REST_RAD,
            "it still moves, from {before} to {reached} rad"
        );
    }
    reached.iter().map(|at| at - std::f64::consts::PI).collect()
}
