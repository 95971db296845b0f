//! Slow motion of position servos: goals in steps of the encoder, and the servo's own profile that smooths them.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the drives' side is f32, the servos' f64, and milliseconds are counted"
)]

use sinew_core::coordinates::DofCommand;
use sinew_core::tracker::Timing;
use sinew_firmware::drives::{Condition, DriveSettings, Drives, PositionSettings};
use sinew_rig::board::BoardRig;
use sinew_rig::new;
use sinew_servo_bus::dynamixel::{self, table::MODELS};
use sinew_servo_bus::feetech::{self, Family};
use sinew_servo_bus::{Command, Schedule, ServoBus, Timing as BusTiming};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::{Arm, Plant, Push, Shaft};
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

const TICK_US: u32 = 10_000;
const RATE_HZ: u32 = 100;
/// Time until the servo follows, and duration of the measurement, s.
const START_S: f64 = 4.0;
const LOOK_S: f64 = 8.0;

/// A servo, with the resolution of its speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Kind {
    /// Speeds in steps of 0.229 rev/min.
    Xl330,
    /// Speeds in steps of 50 counts/s, without bit 2 of its Phase.
    Sts3215Coarse,
    /// Speeds in steps of a count/s, as shipped.
    Sts3215,
}

/// Motion of the shaft in each millisecond.
struct Watched {
    arm: Arm,
    shafts: Vec<Shaft>,
    torques_nm: Vec<f64>,
}

impl Plant for Watched {
    type Load = Arm;

    fn load(&self, _: usize) -> Arm {
        self.arm
    }

    fn step(&mut self, _: f64, pushes: &[Push], shafts: &mut [Shaft]) {
        self.shafts.push(shafts[0]);
        self.torques_nm.push(pushes[0].torque_nm);
    }
}

/// Roughness of a motion.
#[derive(Debug, Clone, Copy)]
struct Ripple {
    /// Largest movement in 10 ms, divided by the movement at the requested speed.
    largest_step: f64,
    /// Root mean square of the speed's deviation from the requested speed, deg/s.
    speed_deg_s: f64,
    /// Root mean square of the torque's change at the shaft per millisecond, mN m: the audible part.
    buzz_mnm: f64,
}

fn ripple(kind: Kind, deg_s: f64, profile: bool) -> Ripple {
    let is_feetech = kind != Kind::Xl330;
    let model = if is_feetech { "STS3215-7.4V" } else { "XL330-M288-T" };
    let parameters = Parameters::built_in(model).unwrap();
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Servo::new(&parameters, 1, &mut memory).unwrap();
    servo.set_baud(1_000_000).unwrap();
    if kind == Kind::Sts3215Coarse {
        servo.set(18, servo.get(18) & !4);
    }
    if !is_feetech {
        servo.set(9, 1);
        servo.set(68, 1);
    }
    // A tenth of the stall torque in a constant direction keeps the gear out of its play.
    let stall_nm =
        parameters.torque_constant_nm_a * parameters.voltage_v / parameters.resistance_ohm;
    let arm = Arm { inertia_kg_m2: 1e-3, torque_nm: -0.1 * stall_nm, ..Arm::default() };
    let watched = Watched { arm, shafts: Vec::new(), torques_nm: Vec::new() };
    let mut bench = Bench::new(vec![servo], watched, Supply::stiff(parameters.voltage_v));

    let mut description = new::arm(1).unwrap();
    model.clone_into(&mut description.servos[0].model);
    let board = BoardRig::<2, 1, 1>::bake(&description, &description.mechanism().unwrap()).unwrap();
    let settings = PositionSettings { profile, ..PositionSettings::default() };
    let timing = Timing { dt_s: 1e-6 * TICK_US as f32, latency_ticks: 1 };
    let drives = Drives::new(&board, &[DriveSettings::Position(settings)], timing).unwrap();

    let wire = BusTiming { baud: 1_000_000, return_delay_us: 2, turnaround_us: 5 };
    if is_feetech {
        let family = Family::Sts;
        let traffic = feetech::traffic(family, 1).with_goal(6);
        let schedule = Schedule::new(wire, &traffic, RATE_HZ).unwrap();
        let setup = feetech::ServoSetup {
            id: 1,
            mode: feetech::Mode::Position,
            range_rad: [0.0, 6.2],
            pwm: 1.0,
            speed_rad_s: 10.0,
        };
        let speed_counts = if kind == Kind::Sts3215Coarse { 50 } else { 1 };
        let settings = feetech::Settings { family, echo: false, retries: 1, speed_counts };
        let mut bus = feetech::Bus::<1>::new(&[setup], schedule, settings).unwrap();
        follow(drives, &mut bus, &mut bench, deg_s)
    } else {
        let schedule = Schedule::new(wire, &dynamixel::traffic(1, 8, false), RATE_HZ).unwrap();
        let setup = dynamixel::ServoSetup {
            id: 1,
            model: MODELS.iter().find(|model| model.name == "XL330-M288").unwrap(),
            mode: dynamixel::Mode::Position,
            range_rad: [0.0, 6.2],
            current_a: 1.0,
            pwm: 1.0,
            speed_rad_s: 15.0,
        };
        let settings = dynamixel::Settings { fast: false, retries: 1 };
        let mut bus = dynamixel::Bus::<1>::new(&[setup], schedule, settings).unwrap();
        follow(drives, &mut bus, &mut bench, deg_s)
    }
}

fn follow(
    mut drives: Drives<'_, 2, 1, 1>,
    bus: &mut impl ServoBus,
    bench: &mut Bench<'_, Watched>,
    deg_s: f64,
) -> Ripple {
    let rad_s = deg_s.to_radians();
    let ticks = ((START_S + LOOK_S) * f64::from(RATE_HZ)) as u32;
    let mut out = [None];
    for tick in 0..ticks {
        let condition = Condition::of(bus, 0);
        if tick == 1 {
            drives.begin(&[condition]);
            bus.command(0, Command::Torque(true)).unwrap();
        }
        if tick > 0 {
            let position = (rad_s * f64::from(tick) / f64::from(RATE_HZ)) as f32;
            let asked = DofCommand { position, velocity: rad_s as f32, ..DofCommand::default() };
            drives.step(&[asked], &[condition], &mut out).unwrap();
            bus.command(0, out[0].unwrap().command).unwrap();
        }
        bench.tick(bus, TICK_US).unwrap();
    }
    let first = (START_S * 1e3) as usize;
    let Watched { shafts, torques_nm, .. } = &bench.plant;
    let (shafts, torques_nm) = (&shafts[first..], &torques_nm[first..]);
    let rms = |of: &mut dyn Iterator<Item = f64>| {
        let (sum, count) = of.fold((0.0, 0.0), |(sum, count), x| (sum + x * x, count + 1.0));
        (sum / count).sqrt()
    };
    let moved = |pair: &[Shaft]| pair[10].position_rad - pair[0].position_rad;
    let mean = (shafts[shafts.len() - 1].position_rad - shafts[0].position_rad)
        / (1e-3 * (shafts.len() - 1) as f64);
    assert!((mean / rad_s - 1.0).abs() < 0.02, "it does not follow: {mean} of {rad_s} rad/s");
    Ripple {
        largest_step: shafts.windows(11).map(moved).fold(0.0, f64::max) / (0.01 * rad_s),
        speed_deg_s: rms(&mut shafts.iter().map(|shaft| shaft.velocity_rad_s - rad_s)).to_degrees(),
        buzz_mnm: 1e3 * rms(&mut torques_nm.windows(2).map(|pair| pair[1] - pair[0])),
    }
}

#[test]
fn slow_motion_keeps_within_the_steps_of_the_encoder_and_the_profile_smooths_it() {
    println!(
        "| servo | deg/s | largest step | by profile | speed rms | by profile | torque's steps | by profile |"
    );
    println!("| --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |");
    // Time to 63 % of a small step: docs/simulated-servos.md.
    for (kind, responds_s) in
        [(Kind::Xl330, 0.0955), (Kind::Sts3215Coarse, 0.0618), (Kind::Sts3215, 0.0618)]
    {
        for deg_s in [1.0, 3.0, 10.0] {
            let [goals, profile] = [false, true].map(|profile| ripple(kind, deg_s, profile));
            println!(
                "| {kind:?} | {deg_s:.0} | {:.2} | {:.2} | {:.2} | {:.2} | {:.3} | {:.3} |",
                goals.largest_step,
                profile.largest_step,
                goals.speed_deg_s,
                profile.speed_deg_s,
                goals.buzz_mnm,
                profile.buzz_mnm
            );
            // A goal jumps by a count of the encoder. A servo with response time T moves by at most 1/T of the count
            // in a second, in addition to its normal movement.
            let bound = 1.0 + 360.0 / 4096.0 / (responds_s * deg_s);
            for ripple in [goals, profile] {
                assert!(
                    ripple.largest_step < bound,
                    "{kind:?}, {deg_s} deg/s: {ripple:?}, {bound}"
                );
            }
            // Speeds below the servo's smallest step are rounded up: the movement is then as jerky as without a
            // profile, but not worse. A tenth is the difference between two such motions.
            let most = match (kind, deg_s) {
                (Kind::Xl330 | Kind::Sts3215Coarse, 1.0) => 1.1,
                _ => 0.9,
            };
            assert!(
                profile.buzz_mnm < most * goals.buzz_mnm,
                "{kind:?}, {deg_s}: {profile:?} {goals:?}"
            );
        }
    }
}
