//! Tests of servos whose controller dies during a show.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Feed, State};

use super::play::show;
use super::test_rig::{Kind, NOTHING_A, SERVOS, TestRig};

/// Register of a Dynamixel's bus watchdog. It contains -1 after the watchdog has expired.
const WATCHDOG: u16 = 98;
/// Register of a Dynamixel's PWM goal, a part of the supply.
const GOAL_PWM: u16 = 100;

/// Returns a rig that plays away from home, where its servos carry weight.
fn playing(kind: Kind) -> TestRig {
    let mut test_rig = TestRig::new(kind, Start::default());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    test_rig.tick(Some(Command::Play(Feed::Show)));
    // Friction of XL430 holds the arm at home, so its way to the show is shorter.
    test_rig.run(if kind == Kind::Voltage { 4.0 } else { 8.0 });
    assert_eq!((test_rig.state(), test_rig.servos_on()), (State::Playing, SERVOS));
    assert!(test_rig.most_current_a() > 0.05, "{} A", test_rig.most_current_a());
    test_rig
}

fn watchdogs(test_rig: &TestRig) -> Vec<i32> {
    test_rig.bench.servos().iter().map(|servo| servo.get(WATCHDOG)).collect()
}

#[test]
fn servos_by_current_are_without_torque_100_ms_after_their_controller_died() {
    let mut test_rig = playing(Kind::Current);
    assert_eq!(watchdogs(&test_rig), [5; SERVOS]);
    // The last packet was sent at the beginning of the tick before.
    test_rig.bench.run_us(95_000);
    assert!(test_rig.most_current_a() > NOTHING_A, "{} A", test_rig.most_current_a());
    assert_eq!(watchdogs(&test_rig), [5; SERVOS]);
    // The servos' own program needs a tick more.
    test_rig.bench.run_us(7_000);
    assert_eq!(watchdogs(&test_rig), [-1; SERVOS]);
    assert!(test_rig.most_current_a() < NOTHING_A, "{} A", test_rig.most_current_a());
    // Their registers still report torque on, but they accept no goal.
    assert_eq!(test_rig.servos_on(), SERVOS);
}

/// The motors of these servos are shorted: the arm sinks slowly and does not fall.
#[test]
fn servos_by_voltage_brake_100_ms_after_their_controller_died() {
    let mut test_rig = playing(Kind::Voltage);
    let most_pwm = |test_rig: &TestRig| {
        let goals = test_rig.bench.servos().iter().map(|servo| servo.get(GOAL_PWM).abs());
        goals.max().unwrap()
    };
    test_rig.bench.run_us(95_000);
    assert!(most_pwm(&test_rig) > 0);
    test_rig.bench.run_us(7_000);
    assert_eq!((most_pwm(&test_rig), watchdogs(&test_rig)), (0, vec![-1; SERVOS]));
    assert_eq!(test_rig.servos_on(), SERVOS);
}

/// The controller was only paused: the stopped servos are a fault, and they move again after they were armed again.
#[test]
fn a_servo_that_has_stopped_is_a_fault_until_it_is_armed_anew() {
    let mut test_rig = playing(Kind::Current);
    test_rig.pause(0.15);
    let ticks = (0..test_rig.ticks_of(1.0)).find(|_| {
        test_rig.tick(None);
        test_rig.controller.report().present.contains(Fault::ServoStopped)
    });
    // In each tick one servo is asked, in turn.
    assert!(ticks.is_some_and(|ticks| ticks <= SERVOS as u32), "{ticks:?}");
    assert_eq!(test_rig.state(), State::Lowering);
    test_rig.until(State::Faulted, 20.0);
    test_rig.run(0.5);
    assert_eq!(watchdogs(&test_rig), [5; SERVOS]);
    test_rig.tick(Some(Command::ClearFaults));
    assert_eq!(test_rig.state(), State::Limp, "{:?}", test_rig.controller.report());
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    test_rig.run(1.0);
    assert!(!test_rig.controller.report().present.contains(Fault::ServoStopped));
    assert!(test_rig.most_current_a() > NOTHING_A);
}

/// A Feetech has no watchdog: it moves to its last goal and holds it. Only the board's own watchdog, and the wire
/// that cuts the servos' supply, can stop it.
#[test]
fn servos_by_position_of_the_other_maker_hold_their_last_goal() {
    let mut test_rig = playing(Kind::Position);
    test_rig.bench.run_us(2_000_000);
    assert_eq!(test_rig.servos_on(), SERVOS);
    assert!(test_rig.most_current_a() > NOTHING_A, "{} A", test_rig.most_current_a());
}
