//! Tests every fault as a master sees it over the wire.

use sinew_servo_bus::dynamixel::{Mode, hardware_error};
use sinew_servo_bus::{Command, Effort, ServoBus};
use sinew_servo_sim::fault::{Fault, FaultKind};
use sinew_servo_sim::load::Arm;
use sinew_servo_sim::supply::Supply;

use crate::common::{MIDDLE, bench, master, registers};

const TICK_US: u32 = 5_000;

/// Observations of a master for a servo, during and after its fault.
#[derive(Debug, Default)]
struct Seen {
    oldest_ticks: u32,
    furthest_rad: f32,
    weakest_a: f32,
    hottest_c: f32,
    errors: u8,
    age_after: u32,
    position_after: f32,
    torque_after: i32,
}

/// Index of the servo with the fault: the last, because in a sync read the servos after a silent servo are late too.
const ILL: usize = 2;

/// Runs three servos with a small weight each. The last has a fault from 0.5 to 1 s, and the others must not be
/// affected. With `swings`, the last servo moves to and fro.
fn seen(kind: FaultKind, swings: bool) -> Seen {
    let mut memory = registers(3);
    let arm = Arm { inertia_kg_m2: 3e-4, torque_nm: -0.05, ..Arm::default() };
    let mut bench = bench(&mut memory, arm, Supply::stiff(5.0));
    bench.faults.push(Fault { servo: ILL, at_s: 0.5, for_s: 0.5, kind });
    let mut bus = master::<3>(Mode::Position, 200);
    let mut seen = Seen { weakest_a: f32::INFINITY, ..Seen::default() };
    let mut start = 0.0;
    for tick in 0..300 {
        if swings {
            let goal = MIDDLE + if tick % 40 < 20 { 0.4 } else { -0.4 };
            bus.command(ILL, Command::Position(goal)).unwrap();
        }
        bench.tick(&mut bus, TICK_US).unwrap();
        for healthy in [0, 1] {
            let feedback = bus.feedback(healthy).unwrap();
            assert_eq!(feedback.age_ticks, 0, "servo {healthy} at tick {tick} of {kind:?}");
            // Tolerance: sag of 0.05 N m over 0.7 N m/rad, also during the motion.
            assert!((feedback.position_rad - MIDDLE).abs() < 0.15, "{feedback:?}");
        }
        let (feedback, health) = (bus.feedback(ILL).unwrap(), bus.health(ILL).unwrap());
        if tick == 99 {
            start = feedback.position_rad;
        }
        if (110..198).contains(&tick) {
            seen.oldest_ticks = seen.oldest_ticks.max(feedback.age_ticks);
            seen.furthest_rad = seen.furthest_rad.max((feedback.position_rad - start).abs());
            seen.hottest_c = seen.hottest_c.max(health.temperature_c.unwrap_or(0.0));
            if let Effort::Current(amps) = feedback.effort {
                seen.weakest_a = seen.weakest_a.min(amps.abs());
            }
        }
        seen.errors |= health.hardware_error;
    }
    let feedback = bus.feedback(ILL).unwrap();
    (seen.age_after, seen.position_after) = (feedback.age_ticks, feedback.position_rad);
    seen.torque_after = bench.servos()[ILL].get(64);
    seen
}

#[test]
fn a_healthy_servo_answers_and_moves() {
    let seen = seen(FaultKind::EncoderJump(0.0), true);
    assert_eq!((seen.oldest_ticks, seen.age_after, seen.errors, seen.torque_after), (0, 0, 0, 1));
    assert!(seen.furthest_rad > 0.2, "{seen:?}");
}

#[test]
fn replies_that_do_not_come_or_are_damaged_are_missed_and_nothing_else() {
    for kind in [
        FaultKind::Silent,
        FaultKind::Late(3_000),
        FaultKind::WrongCheck,
        FaultKind::Short(9),
        FaultKind::WrongId(77),
    ] {
        let seen = seen(kind, false);
        assert!(seen.oldest_ticks > 50, "{kind:?}: {seen:?}");
        assert_eq!((seen.age_after, seen.errors, seen.torque_after), (0, 0, 1), "{kind:?}");
    }
}

#[test]
fn a_jammed_servo_stays_where_it_is() {
    let seen = seen(FaultKind::Stuck, true);
    assert_eq!(seen.oldest_ticks, 0);
    assert!(seen.furthest_rad < 0.05, "{seen:?}");
}

#[test]
fn a_hot_servo_says_so_and_shuts_down() {
    let seen = seen(FaultKind::Hot(75.0), false);
    assert!((seen.hottest_c - 75.0).abs() < 0.6, "{seen:?}");
    assert_eq!(seen.errors, hardware_error::OVERHEATING);
    assert_eq!(seen.torque_after, 0);
}

#[test]
fn a_servo_without_supply_is_silent_and_comes_back_limp() {
    for (kind, least_ticks) in [(FaultKind::BrownOut, 80), (FaultKind::Reboot, 30)] {
        let seen = seen(kind, false);
        assert!(seen.oldest_ticks >= least_ticks, "{kind:?}: {seen:?}");
        assert_eq!((seen.age_after, seen.torque_after), (0, 0), "{kind:?}: {seen:?}");
        assert!((seen.position_after - MIDDLE).abs() > 0.3, "the weight has pulled it: {seen:?}");
    }
}

#[test]
fn lost_torque_shows_as_a_current_that_is_gone() {
    let seen = seen(FaultKind::TorqueLost, false);
    assert_eq!((seen.oldest_ticks, seen.errors, seen.torque_after), (0, 0, 0));
    assert!(seen.weakest_a < 0.001, "{seen:?}");
}

#[test]
fn an_encoder_that_jumps_is_seen_to_jump() {
    let seen = seen(FaultKind::EncoderJump(1.0), false);
    assert_eq!(seen.oldest_ticks, 0);
    assert!(seen.furthest_rad > 0.3, "{seen:?}");
    // The servo returns by itself, because its encoder reports a distance from its goal.
    assert!((seen.position_after - MIDDLE).abs() < 0.2, "{seen:?}");
}
