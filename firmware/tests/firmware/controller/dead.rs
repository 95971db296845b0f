//! A controller that dies in a show: what servos do that hear nothing any more.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Feed, State};

use super::play::show;
use super::test_rig::{Kind, NOTHING_A, SERVOS, TestRig};

/// The watchdog of a Dynamixel, and what it holds when it has run out.
const WATCHDOG: u16 = 98;
/// The part of the supply that a Dynamixel is asked for.
const GOAL_PWM: u16 = 100;

/// A stand that plays, away from home, where its servos carry.
fn playing(kind: Kind) -> TestRig {
    let mut test_rig = TestRig::new(kind, Start::default());
    test_rig.controller.load_show(Some(show(kind, 0))).unwrap();
    test_rig.arm();
    test_rig.until(State::Holding, 2.0);
    test_rig.tick(Some(Command::Play(Feed::Show)));
    // Friction of XL430 holds the arm at home: its way to the show is shorter.
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
    // The last packet was at the beginning of the tick before.
    test_rig.bench.run_us(95_000);
    assert!(test_rig.most_current_a() > NOTHING_A, "{} A", test_rig.most_current_a());
    assert_eq!(watchdogs(&test_rig), [5; SERVOS]);
    // And a tick of their own program.
    test_rig.bench.run_us(7_000);
    assert_eq!(watchdogs(&test_rig), [-1; SERVOS]);
    assert!(test_rig.most_current_a() < NOTHING_A, "{} A", test_rig.most_current_a());
    // Their registers say that torque is on: they take no goal.
    assert_eq!(test_rig.servos_on(), SERVOS);
}

/// Their motors are shorted: what they carried sinks, and does not fall.
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

/// It was not dead, it stood still for a while: servos that have stopped are told, and move again after they were
/// armed anew.
#[test]
fn a_servo_that_has_stopped_is_a_fault_until_it_is_armed_anew() {
    let mut test_rig = playing(Kind::Current);
    test_rig.pause(0.15);
    let ticks = (0..test_rig.ticks_of(1.0)).find(|_| {
        test_rig.tick(None);
        test_rig.controller.report().present.contains(Fault::ServoStopped)
    });
    // Each servo in its turn is asked in each tick.
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

/// A Feetech has no watchdog: it goes to its last goal, and holds it. The board's own watchdog and the wire that cuts
/// its supply are all there is.
#[test]
fn servos_by_position_of_the_other_maker_hold_their_last_goal() {
    let mut test_rig = playing(Kind::Position);
    test_rig.bench.run_us(2_000_000);
    assert_eq!(test_rig.servos_on(), SERVOS);
    assert!(test_rig.most_current_a() > NOTHING_A, "{} A", test_rig.most_current_a());
}
