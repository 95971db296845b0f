//! Compares the times of a schedule with the times of the bytes on a simulated wire: the table of `docs/buses.md`,
//! printed by `cargo test -p sinew-servo-sim --test servo_sim rates -- --nocapture`.

use sinew_servo_bus::dynamixel::table::MODELS;
use sinew_servo_bus::dynamixel::{Bus, Mode, ServoSetup, Settings, traffic};
use sinew_servo_bus::{Command, Schedule, ServoBus, Timing};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, Servo};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

const TURNAROUND_US: u32 = 5;
const TICKS: u32 = 20;

/// Returns the wire time of a tick with `servos` XL330, us: all servos are written and read, and the supply voltage of
/// one servo is read. The time is computed from the bytes on the wire and the pauses of the servos, independently of
/// the schedule.
fn wire_us(servos: u8, baud: u32, fast: bool) -> f64 {
    let kind = Parameters::built_in("XL330-M288-T").unwrap();
    let mut memory = vec![[0; MEMORY_LEN]; servos.into()];
    let on_line = (1..).zip(&mut memory).map(|(id, memory)| {
        let mut servo = Servo::new(&kind, id, memory).unwrap();
        servo.set_baud(baud).unwrap();
        servo.set(9, 1);
        servo.set(68, 1);
        servo
    });
    let arms = vec![Arm::default(); servos.into()];
    let mut bench = Bench::new(on_line.collect(), arms, Supply::stiff(5.0));
    let timing = Timing { baud, return_delay_us: 2, turnaround_us: TURNAROUND_US };
    // The rate is low enough to read all servos in every tick.
    let schedule = Schedule::new(timing, &traffic(servos.into(), 4, fast), 20).unwrap();
    assert_eq!(schedule.groups(), 1);
    let setups: Vec<_> = (1..=servos)
        .map(|id| ServoSetup {
            id,
            model: MODELS.iter().find(|model| model.name == "XL330-M288").unwrap(),
            mode: Mode::Position,
            range_rad: [0.5, 5.8],
            current_a: 1.5,
            pwm: 1.0,
            speed_rad_s: 15.0,
        })
        .collect();
    let mut bus = Bus::<40>::new(&setups, schedule, Settings { fast, retries: 0 }).unwrap();
    let (mut out, mut waits_us) = ([0; 1024], 0.0);
    for tick in 0..TICKS {
        for servo in 0..servos.into() {
            bus.command(servo, Command::Position(3.1 + 0.01 * tick as f32)).unwrap();
        }
        let mut request = Some(bus.plan(&mut out).unwrap());
        while let Some(asked) = request {
            let (before, before_s) = (bench.traffic().wire_ns, bench.time_s());
            bench.exchange(&out[..asked.len], 40_000, |said| bus.reply(said));
            let talked_us = (bench.traffic().wire_ns - before) as f64 * 1e-3;
            // The measured silence is that of the servos; the controller adds its own turnaround.
            waits_us += 1e6 * (bench.time_s() - before_s) - talked_us + f64::from(TURNAROUND_US);
            request = bus.plan_more(10_000, &mut out).unwrap();
        }
    }
    for servo in 0..servos.into() {
        assert_eq!(bus.feedback(servo).map(|feedback| feedback.age_ticks), Some(0));
        assert_eq!(bus.health(servo).unwrap().missed, 0);
    }
    // 8 bits, start and stop.
    let bytes = bench.traffic().sent + bench.traffic().answered;
    (waits_us + 10.0e6 * bytes as f64 / f64::from(baud)) / f64::from(TICKS)
}

#[test]
fn a_schedule_says_what_the_wire_needs() {
    println!("| servos | Mbps | read | schedule, Hz | wire, Hz | off |");
    let mut worst = 0.0_f64;
    for servos in [6_u8, 18, 40] {
        for mbps in [1, 2, 3, 4] {
            for (fast, how) in [(false, "sync"), (true, "fast")] {
                let baud = 1_000_000 * mbps;
                let timing = Timing { baud, return_delay_us: 2, turnaround_us: TURNAROUND_US };
                let says_hz = Schedule::fastest_hz(&timing, &traffic(servos.into(), 4, fast));
                let wire_hz = 1e6 / wire_us(servos, baud, fast);
                let off = f64::from(says_hz) / wire_hz - 1.0;
                println!(
                    "| {servos} | {mbps} | {how} | {says_hz} | {wire_hz:.0} | {:+.1} % |",
                    100.0 * off
                );
                worst = worst.max(off.abs());
            }
        }
    }
    assert!(worst < 0.05, "{worst}");
}
