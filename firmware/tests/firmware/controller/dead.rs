//! A controller that dies in a show: what servos do that hear nothing any more.

use sinew_firmware::controller::Start;
use sinew_firmware::supervisor::{Command, Fault, Feed, State};

use super::play::show;
use super::stand::{Kind, NOTHING_A, SERVOS, Stand};

/// The watchdog of a Dynamixel, and what it holds when it has run out.
const WATCHDOG: u16 = 98;

/// A stand that plays, away from home, where its servos carry.
fn playing(kind: Kind) -> Stand {
    let mut stand = Stand::new(kind, Start::default());
    stand.controller.load_show(Some(show(kind, 0))).unwrap();
    stand.arm();
    stand.until(State::Holding, 2.0);
    stand.tick(Some(Command::Play(Feed::Show)));
    stand.run(8.0);
    assert_eq!((stand.state(), stand.servos_on()), (State::Playing, SERVOS));
    assert!(stand.most_current_a() > 0.05, "{} A", stand.most_current_a());
    stand
}

fn watchdogs(stand: &Stand) -> Vec<i32> {
    stand.bench.servos().iter().map(|servo| servo.get(WATCHDOG)).collect()
}

#[test]
fn servos_by_current_are_without_torque_100_ms_after_their_controller_died() {
    let mut stand = playing(Kind::Current);
    assert_eq!(watchdogs(&stand), [5; SERVOS]);
    // The last packet was at the beginning of the tick before.
    stand.bench.run_us(95_000);
    assert!(stand.most_current_a() > NOTHING_A, "{} A", stand.most_current_a());
    assert_eq!(watchdogs(&stand), [5; SERVOS]);
    // And a tick of their own program.
    stand.bench.run_us(7_000);
    assert_eq!(watchdogs(&stand), [-1; SERVOS]);
    assert!(stand.most_current_a() < NOTHING_A, "{} A", stand.most_current_a());
    // Their registers say that torque is on: they take no goal.
    assert_eq!(stand.servos_on(), SERVOS);
}

/// It was not dead, it stood still for a while: servos that have stopped are told, and move again after they were
/// armed anew.
#[test]
fn a_servo_that_has_stopped_is_a_fault_until_it_is_armed_anew() {
    let mut stand = playing(Kind::Current);
    stand.pause(0.15);
    let ticks = (0..stand.ticks_of(1.0)).find(|_| {
        stand.tick(None);
        stand.controller.report().present.contains(Fault::ServoStopped)
    });
    // Each servo in its turn is asked in each tick.
    assert!(ticks.is_some_and(|ticks| ticks <= SERVOS as u32), "{ticks:?}");
    assert_eq!(stand.state(), State::Lowering);
    stand.until(State::Faulted, 4.0);
    stand.run(0.5);
    assert_eq!(watchdogs(&stand), [5; SERVOS]);
    stand.tick(Some(Command::ClearFaults));
    assert_eq!(stand.state(), State::Limp, "{:?}", stand.controller.report());
    stand.arm();
    stand.until(State::Holding, 2.0);
    stand.run(1.0);
    assert!(!stand.controller.report().present.contains(Fault::ServoStopped));
    assert!(stand.most_current_a() > NOTHING_A);
}

/// A Feetech has no watchdog: it goes to its last goal, and holds it. The board's own watchdog and the wire that cuts
/// its supply are all there is.
#[test]
fn servos_by_position_of_the_other_maker_hold_their_last_goal() {
    let mut stand = playing(Kind::Position);
    stand.bench.run_us(2_000_000);
    assert_eq!(stand.servos_on(), SERVOS);
    assert!(stand.most_current_a() > NOTHING_A, "{} A", stand.most_current_a());
}
