//! Tests of energy, temperature, supply, watchdog, determinism and speed.

#![expect(clippy::cast_possible_truncation, reason = "goals go over the bus as f32")]

use std::hash::{DefaultHasher, Hash, Hasher};
use std::time::Instant;

use sinew_servo_bus::dynamixel::{Mode, hardware_error};
use sinew_servo_bus::{BusDevice, Command, ServoBus, feetech};
use sinew_servo_sim::bench::Bench;
use sinew_servo_sim::device::{MEMORY_LEN, STEP_S, Servo};
use sinew_servo_sim::fault;
use sinew_servo_sim::load::{Arm, Load};
use sinew_servo_sim::model::Parameters;
use sinew_servo_sim::supply::Supply;

use crate::common::{MIDDLE, bench, master, registers};

/// Writes the goal position of an STS servo.
fn sts_goal(servo: &mut Servo<'_>, counts: u16) {
    let mut out = [0; 32];
    let write = feetech::Instruction::Write { address: 42, data: &counts.to_le_bytes() };
    let len = write.encode(feetech::Family::Sts, 1, &mut out).unwrap();
    servo.hear(&out[..len]);
    servo.speak(&mut out);
}

#[test]
fn no_energy_comes_from_nothing() {
    let kind = Parameters::built_in("STS3215-7.4V").unwrap();
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Servo::new(&kind, 1, &mut memory).unwrap();
    let arm = Arm { inertia_kg_m2: 0.01, gravity_nm: 0.6, ..Arm::default() };
    let stored = |servo: &mut Servo<'_>| {
        let height = arm.gravity_nm * libm::sin(servo.shaft().position_rad);
        servo.gear_mut().energy_j(arm.inertia_kg_m2()) + height
    };
    let before = stored(&mut servo);
    let (mut given, mut lost, mut worst) = (0.0, 0.0, f64::INFINITY);
    for step in 0..20_000 {
        if step % 4_000 == 0 {
            sts_goal(&mut servo, if step % 8_000 == 0 { 1_000 } else { 3_000 });
        }
        servo.step(7.4, &arm);
        given += STEP_S * 7.4 * (servo.draw().current_a - kind.standby_a);
        lost += STEP_S * servo.lost_w().iter().sum::<f64>();
        worst = f64::min(worst, given - lost - (stored(&mut servo) - before));
    }
    let missing = given - lost - (stored(&mut servo) - before);
    println!("{given:.3} J given, {lost:.3} J lost, {missing:.4} J missing, {worst:.5} J at worst");
    // Implicit Euler loses a few per cent of the energy of a motion with starts and stops.
    assert!(missing < 0.05 * given);
    // Gravity and windup are computed at the beginning of a step, which causes an error of half a step's motion.
    assert!(worst > -0.005 * given, "{worst} J");
}

#[test]
fn a_stalled_servo_warms_until_it_shuts_down() {
    let mut memory = registers(1);
    let wall = Arm { inertia_kg_m2: 1e4, ..Arm::default() };
    let mut bench = bench(&mut memory, wall, Supply::stiff(5.0));
    let servo = &mut bench.servos_mut()[0];
    servo.set(11, 16);
    // Only excess temperature shuts the servo down: otherwise an overload would do so first.
    servo.set(63, i32::from(hardware_error::OVERHEATING));
    let mut bus = master::<1>(Mode::Pwm, 50);
    bus.command(0, Command::Pwm(1.0)).unwrap();
    while bench.servos()[0].get(64) == 1 || bench.time_s() < 1.0 {
        bench.tick(&mut bus, 500_000).unwrap();
        assert!(bench.time_s() < 900.0);
    }
    let (time_s, heat) = (bench.time_s(), bench.servos()[0].heat());
    println!(
        "off after {time_s:.0} s: winding {:.0}, case {:.0} degC",
        heat.winding_c, heat.case_c
    );
    // The winding heats with 7.4 W, and with less as copper warms. A case of 24 K/W and 600 s must warm by 45 K. At
    // constant power this takes 600 s ln(1 / (1 - 45 / 175)) = 180 s, plus the time of the winding.
    assert!((120.0..400.0).contains(&time_s), "{time_s} s");
    for _ in 0..4 {
        bench.tick(&mut bus, 500_000).unwrap();
    }
    assert!(bus.health(0).unwrap().alert);
    assert_ne!(bench.servos()[0].get(70) & i32::from(hardware_error::OVERHEATING), 0);
}

#[test]
fn an_overload_shuts_a_dynamixel_down_and_makes_a_feetech_weak() {
    let wall = Arm { inertia_kg_m2: 1e4, ..Arm::default() };
    let mut memory = registers(1);
    let mut bench = bench(&mut memory, wall, Supply::stiff(5.0));
    bench.servos_mut()[0].set(11, 16);
    let mut bus = master::<1>(Mode::Pwm, 50);
    bus.command(0, Command::Pwm(1.0)).unwrap();
    for _ in 0..150 {
        bench.tick(&mut bus, 20_000).unwrap();
    }
    assert_eq!(bus.health(0).unwrap().hardware_error, hardware_error::OVERLOAD);
    assert_eq!(bench.servos()[0].get(64), 0);

    let kind = Parameters::built_in("STS3215-7.4V").unwrap();
    let mut memory = [0; MEMORY_LEN];
    let mut servo = Servo::new(&kind, 1, &mut memory).unwrap();
    sts_goal(&mut servo, 4_000);
    let mut currents = [0.0; 2];
    for (current, steps) in currents.iter_mut().zip([4_000, 8_000]) {
        (0..steps).for_each(|_| servo.step(7.4, &wall));
        *current = servo.current_a();
    }
    // The torque is full for 2 s, then 20 %.
    assert!(currents[0] > 1.8 && (currents[1] - 0.4).abs() < 0.05, "{currents:?}");
    servo.hear(&[0xFF, 0xFF, 1, 4, 2, 65, 1, !(1 + 4 + 2 + 65 + 1)]);
    assert_eq!(servo.get(65), 1 << 5);
}

#[test]
fn servos_sag_their_supply_together_and_brown_out() {
    let wall = Arm { inertia_kg_m2: 1e4, ..Arm::default() };
    for (limit_a, reboots) in [(f64::INFINITY, false), (3.0, true)] {
        let mut memory = registers(6);
        let supply = Supply::new(5.0, 0.1, limit_a, 1e-3);
        let mut bench = bench(&mut memory, wall, supply);
        for servo in bench.servos_mut() {
            servo.set(11, 16);
        }
        let mut bus = master::<6>(Mode::Pwm, 100);
        for servo in 0..6 {
            bus.command(servo, Command::Pwm(1.0)).unwrap();
        }
        for _ in 0..20 {
            bench.tick(&mut bus, 10_000).unwrap();
        }
        let on = bench.servos().iter().filter(|servo| servo.get(64) == 1).count();
        if reboots {
            assert_eq!(on, 0, "all were reset");
        } else {
            // Six servos of 3.4 ohm, and 6 times 17 mA: (5 - 0.01) / (1 + 0.6 / 3.4).
            let volts = bench.supplies[0].voltage_v();
            assert!((volts - 4.242).abs() < 0.03, "{volts} V");
            assert_eq!(on, 6);
            assert!((bus.health(2).unwrap().voltage_v.unwrap() - 4.2).abs() < 0.11);
        }
    }
}

#[test]
fn the_bus_watchdog_stops_what_nobody_commands() {
    let mut memory = registers(1);
    let mut bench = bench(&mut memory, Arm::default(), Supply::stiff(5.0));
    // About 3 rev/min, so that the servo is still moving.
    bench.servos_mut()[0].set(112, 13);
    bench.servos_mut()[0].set(98, 5);
    let mut bus = master::<1>(Mode::Position, 100);
    bus.command(0, Command::Position(MIDDLE + 2.0)).unwrap();
    for _ in 0..20 {
        bench.tick(&mut bus, 10_000).unwrap();
    }
    bench.run_us(110_000);
    let stopped = bench.servos()[0].shaft().position_rad;
    bench.run_us(1_000_000);
    assert_eq!(bench.servos()[0].get(98), -1);
    let crept = bench.servos()[0].shaft().position_rad - stopped;
    assert!(crept.abs() < 0.05, "{crept} rad");
    assert!(stopped > f64::from(MIDDLE) + 0.02 && stopped < f64::from(MIDDLE) + 1.0, "{stopped}");
}

#[test]
fn a_hobby_servo_follows_pulses_and_lets_go_without() {
    let kind = Parameters::built_in("MG996R").unwrap();
    let servo = Servo::on_pulses(&kind);
    let arm = Arm { inertia_kg_m2: 1e-3, torque_nm: -0.2, ..Arm::default() };
    let mut bench = Bench::new(vec![servo], vec![arm], Supply::stiff(6.0));
    bench.servos_mut()[0].set_pulse(Some(2_000.0));
    bench.run_us(1_000_000);
    let middle = 0.5 * kind.range_rad;
    let held = bench.servos()[0].shaft().position_rad;
    // 500 us are an eighth of a turn. Tolerance: 0.2 N m and friction over 12 N m/rad, plus the dead band.
    assert!((held - middle - std::f64::consts::FRAC_PI_4).abs() < 0.05, "{held}");
    bench.servos_mut()[0].set_pulse(None);
    bench.run_us(1_000_000);
    assert!(bench.servos()[0].shaft().position_rad < held - 0.5);
}

/// Returns a hash of the motion of six servos with random faults.
fn fingerprint(seed: u64) -> u64 {
    let mut memory = registers(6);
    let arm = Arm { inertia_kg_m2: 5e-4, gravity_nm: 0.08, ..Arm::default() };
    let mut bench = bench(&mut memory, arm, Supply::new(5.0, 0.1, 10.0, 1e-3));
    bench.faults = fault::random(seed, 12, 6, 2.0);
    let mut bus = master::<6>(Mode::Position, 200);
    let mut hash = DefaultHasher::new();
    for tick in 0..400_u16 {
        for servo in 0..6 {
            let angle = libm::sin(0.03 * f64::from(tick) + servo as f64);
            bus.command(servo, Command::Position(MIDDLE + angle as f32)).unwrap();
        }
        bench.tick(&mut bus, 5_000).unwrap();
        for servo in 0..6 {
            let seen = bus.feedback(servo).map(|f| (f.position_rad.to_bits(), f.age_ticks));
            (seen, bench.servos()[servo].shaft().position_rad.to_bits()).hash(&mut hash);
        }
    }
    (bench.traffic().wire_ns, bench.supplies[0].voltage_v().to_bits()).hash(&mut hash);
    hash.finish()
}

#[test]
fn the_same_seed_gives_the_same_bits() {
    assert_eq!(fingerprint(16), fingerprint(16));
    assert_ne!(fingerprint(16), fingerprint(17));
}

#[test]
fn twenty_servos_run_faster_than_real_time() {
    let mut memory = registers(20);
    let arm = Arm { inertia_kg_m2: 5e-4, gravity_nm: 0.05, ..Arm::default() };
    let mut bench = bench(&mut memory, arm, Supply::new(5.0, 0.02, 40.0, 1e-3));
    let mut bus = master::<20>(Mode::Position, 100);
    let begin = Instant::now();
    for tick in 0..500_u16 {
        let goal = MIDDLE + libm::sin(0.05 * f64::from(tick)) as f32;
        for servo in 0..20 {
            bus.command(servo, Command::Position(goal)).unwrap();
        }
        bench.tick(&mut bus, 10_000).unwrap();
    }
    let ratio = bench.time_s() / begin.elapsed().as_secs_f64();
    println!("20 servos, read and commanded 100 times a second: {ratio:.1} times real time");
    assert!(ratio > 1.0, "{ratio}");
}
