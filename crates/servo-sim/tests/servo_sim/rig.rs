//! Tests a rig on its servos, with one supply for all of them.

use std::time::Instant;

use sinew_rig::new::arm;
use sinew_servo_bus::dynamixel::{Instruction, Mode};
use sinew_servo_bus::{Command, ServoBus};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::Servo;
use sinew_servo_sim::fleet::{self, BusServo, Setup, Wanted};
use sinew_servo_sim::kind::Kind;
use sinew_servo_sim::line::{Line, run_all};
use sinew_servo_sim::plant::RigPlant;
use sinew_servo_sim::rig::servos;
use sinew_servo_sim::supply::Supply;

use crate::common::{BAUD, Registers, master, registers};

const SERVOS: usize = 6;

/// Creates a bench with the desk arm of six XL330.
fn bench(memory: &mut Registers, mode: Mode, supply: Supply) -> Bench<'_, RigPlant> {
    let description = arm(SERVOS).unwrap();
    let mechanism = description.mechanism().unwrap();
    let own = servos(&description, &mechanism).unwrap();
    let names: Vec<&str> = own.iter().map(|servo| servo.name.as_str()).collect();
    let plant = RigPlant::new(&description, &mechanism, &names).unwrap();
    let simulated = own.iter().zip(memory).map(|(own, memory)| {
        let mut servo = Servo::new(&own.kind, own.id().unwrap(), memory).unwrap();
        servo.set_baud(BAUD).unwrap();
        // Return delay 2 us, no answers to writes, shutdown only by temperature.
        for (register, value) in
            [(9, 1), (68, 1), (63, 4), (11, if mode == Mode::Pwm { 16 } else { 3 })]
        {
            servo.set(register, value);
        }
        servo.place(own.home_rad);
        servo
    });
    Bench::new(simulated.collect(), plant, supply)
}

/// All servos drive their joints into the stops at the same time: the supply's resistance carries the sum of their
/// currents, and each servo reads the remaining voltage.
#[test]
fn servos_that_stall_together_pull_the_supply_down_for_all() {
    const OPEN_V: f64 = 5.0;
    const OHM: f64 = 0.1;
    let volts_of = |stalled: usize| -> Vec<i32> {
        let mut memory = registers(SERVOS);
        let mut bench = bench(&mut memory, Mode::Pwm, Supply::new(OPEN_V, OHM, 20.0, 1e-3));
        let mut bus = master::<SERVOS>(Mode::Pwm, 50);
        for servo in 0..SERVOS {
            let pwm = if servo < stalled { 1.0 } else { 0.0 };
            bus.command(servo, Command::Pwm(pwm)).unwrap();
        }
        for _ in 0..100 {
            bench.tick(&mut bus, 20_000).unwrap();
        }
        for servo in &bench.servos()[..stalled] {
            assert!(servo.shaft().velocity_rad_s.abs() < 0.1, "it does not stall");
        }
        // Present input voltage, in 0.1 V.
        bench.servos().iter().map(|servo| servo.get(144)).collect()
    };
    let kind = sinew_servo_sim::model::Parameters::built_in("XL330-M288-T").unwrap();
    for stalled in [0, 1, SERVOS] {
        let volts = volts_of(stalled);
        // Ohm's law, with motors at 25 °C. The standby currents change the voltage by less than one step of the
        // register.
        let motors_s = stalled as f64 / kind.resistance_ohm;
        let left_v = OPEN_V / (1.0 + OHM * motors_s) - OHM * SERVOS as f64 * kind.standby_a;
        println!("{stalled} stalled: {volts:?}, {left_v:.2} V by Ohm's law");
        for volts in volts {
            // Tolerance: one step of the register, plus the warming of the windings in 2 s: 0.4 %/K, some 10 K, of the
            // drop.
            let warm_v = 0.04 * (OPEN_V - left_v);
            assert!((0.1 * f64::from(volts) - left_v).abs() < 0.06 + warm_v, "{volts} {left_v}");
        }
    }
}

/// An angle within the range of a joint of the arm, rad.
const RAISED_RAD: f64 = 1.0;

/// Gravity depends on the pose: a shoulder holds more with the arm stretched out than with the arm folded.
#[test]
fn a_servo_holds_what_the_pose_of_all_asks_for() {
    let mut sags = Vec::new();
    for folded in [0.0, 1.2] {
        let mut memory = registers(SERVOS);
        let mut bench = bench(&mut memory, Mode::Position, Supply::stiff(5.0));
        let homes: Vec<f64> =
            bench.servos().iter().map(|servo| servo.shaft().position_rad).collect();
        let mut bus = master::<SERVOS>(Mode::Position, 50);
        #[expect(clippy::cast_possible_truncation, reason = "goals go over the bus as f32")]
        for (servo, home) in homes.iter().enumerate() {
            let goal = match servo {
                1 => home + RAISED_RAD,
                2 => home + folded,
                _ => *home,
            };
            bus.command(servo, Command::Position(goal as f32)).unwrap();
        }
        for _ in 0..150 {
            bench.tick(&mut bus, 20_000).unwrap();
        }
        let shoulder = &bench.servos()[1];
        let sag = homes[1] + RAISED_RAD - shoulder.shaft().position_rad;
        sags.push(sag.abs());
    }
    println!("sag: {sags:?} rad");
    assert!(sags[1] < 0.9 * sags[0], "{sags:?}");
}

/// Index of the servo whose torque is off, and index of an earlier servo that swings. The joints of both bend the arm.
const LIMP: usize = 4;
const SWINGS: usize = 2;

/// Runs an arm whose servos are on these buses. One servo has no torque, one moves to `goal`, and the others hold.
/// Returns all shaft positions, and the lowest voltage that the servo with torque off reads.
fn on_buses(buses: [&str; SERVOS], goal: i32) -> Vec<f64> {
    let description = arm(SERVOS).unwrap();
    let mechanism = description.mechanism().unwrap();
    let own = servos(&description, &mechanism).unwrap();
    let wanted: Vec<Wanted> = own
        .into_iter()
        .zip(buses)
        .map(|(servo, bus)| Wanted {
            bus: bus.to_owned(),
            id: servo.id().unwrap(),
            name: servo.name,
            kind: Kind::Servo(Box::new(servo.kind)),
            load: servo.load,
            home_rad: Some(servo.home_rad),
        })
        .collect();
    let setup = Setup {
        baud: BAUD,
        rig: Some((&description, &mechanism)),
        supply: Some(Supply::new(5.0, 0.3, 20.0, 1e-3)),
        faults: Vec::new(),
    };
    let mut memory = registers(SERVOS);
    let mut lines = fleet::lines(&wanted, &setup, &mut memory).unwrap();
    let names = fleet::buses(&wanted);
    let mut now_ns = 0;
    let mut write = |lines: &mut [Line<BusServo>], servo: usize, address: u16, data: &[u8]| {
        let mut packet = [0; 32];
        let write = Instruction::Write { address, data };
        let len = write.encode(wanted[servo].id, &mut packet).unwrap();
        lines[names.iter().position(|bus| *bus == buses[servo]).unwrap()].write(&packet[..len]);
        now_ns += 5_000_000;
        run_all(lines, now_ns);
    };
    (0..SERVOS).filter(|servo| *servo != LIMP).for_each(|at| write(&mut lines, at, 64, &[1]));
    write(&mut lines, SWINGS, 116, &goal.to_le_bytes());
    let mut lowest = i32::MAX;
    for _ in 0..60 {
        // A write to a register without effect takes 5 ms.
        write(&mut lines, LIMP, 65, &[0]);
        let BusServo::Servos(branch) = &lines[0].servos else { panic!("they have physics") };
        // Present Input Voltage of this servo, in 0.1 V.
        lowest = lowest.min(branch.bench().servos()[LIMP].get(144));
    }
    let BusServo::Servos(branch) = &lines[0].servos else { panic!("they have physics") };
    let bench = branch.bench();
    let shafts = bench.servos().iter().map(|servo| servo.shaft().position_rad);
    shafts.chain([f64::from(lowest)]).collect()
}

/// With one bus or three buses, bodies and supply are shared, and the results have equal bits.
#[test]
fn servos_feel_each_other_whatever_their_bus() {
    let three = ["left", "left", "left", "tip", "tip", "hand"];
    let (still, moved) = (on_buses(three, 2048), on_buses(three, 2048 + 700));
    println!("{still:?}, {moved:?}");
    // The servo on another bus has torque off. It is moved by more than its encoder's steps (without its neighbours,
    // both runs would be equal), and its supply voltage falls by at least one step of its register.
    assert!((moved[LIMP] - still[LIMP]).abs() > 0.01, "{moved:?} {still:?}");
    assert!(moved[SERVOS] < still[SERVOS], "{moved:?} {still:?}");
    let one = on_buses(["main"; SERVOS], 2048 + 700);
    assert_eq!(moved, one);
}

/// Two runs are equal, bit by bit. The test also prints the run time of a simulated second.
#[test]
fn a_rig_is_deterministic() {
    let run = || {
        let mut memory = registers(SERVOS);
        let mut bench = bench(&mut memory, Mode::Position, Supply::new(5.0, 0.2, 3.0, 1e-3));
        let mut bus = master::<SERVOS>(Mode::Position, 50);
        for tick in 0..50_u8 {
            for servo in 0..SERVOS {
                let goal = 2.5 + 0.02 * f32::from(tick);
                bus.command(servo, Command::Position(goal)).unwrap();
            }
            bench.tick(&mut bus, 20_000).unwrap();
        }
        bench
            .servos()
            .iter()
            .map(|servo| servo.shaft().position_rad.to_bits())
            .collect::<Vec<u64>>()
    };
    let begin = Instant::now();
    let first = run();
    println!("a second of {SERVOS} servos on their rig: {:.3} s", begin.elapsed().as_secs_f64());
    assert_eq!(first, run());
}
