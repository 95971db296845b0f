//! Actions of people near the rig: the emergency stop, maintenance, a second host.

use sinew_firmware::supervisor::State;
use sinew_link::message::{
    self, Command, Feed, Hello, Misfit, Operator, Outcome, Refusal, Stream, ToController, Version,
};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::{Kind, SERVOS};
use super::world::World;

const KIND: Kind = Kind::Current;

fn holding() -> World {
    let mut world = World::ready(KIND, Trouble::default(), 13, &show(KIND, 20, true));
    world.run(2.0);
    world.arm();
    world.until(State::Holding, 3.0);
    world
}

#[test]
fn the_emergency_stop_is_told_and_its_release_moves_nothing() {
    let mut world = holding();
    world.ask(Command::Play(Feed::Show));
    world.run(5.0);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Playing), SERVOS));
    world.pins.is_stopped = true;
    world.tick();
    // Torque is off by the packets of this very tick.
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
    assert!(!world.pins.outputs);
    world.run(1.0);
    assert_eq!(world.ask(Command::ClearFaults), Outcome::Refused(Refusal::StillThere(16)));
    // The first fault survives a loss of power, with its time, even if another fault follows.
    let told = *world.host.faults.iter().find(|fault| !fault.is_warning()).unwrap();
    assert_eq!((told.fault, told.state), (16, message::State::Playing));
    assert!(world.restart());
    world.connect();
    let log = world.board.control.as_ref().unwrap().0.controller().supervisor().log();
    let kept = log.first().unwrap();
    assert_eq!((kept.fault.number(), kept.time_us), (16, told.time_us));
    assert_ne!(log.last().next(), Some(kept));
    world.pins.is_stopped = false;
    world.run(1.0);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
    assert_eq!(world.ask(Command::Arm), Outcome::Refused(Refusal::Fault(16)));
    world.ask(Command::ClearFaults);
    world.run(1.0);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Limp), 0));
}

#[test]
fn maintenance_is_slow_and_ends_with_the_button() {
    let mut world = holding();
    let (ann, bob) = (Operator(1), Operator(2));
    world.ask(Command::Maintain(ann));
    let refused = world.ask(Command::Maintain(bob));
    assert!(matches!(refused, Outcome::Refused(_)), "{refused:?}");
    let place = |world: &World| {
        let (control, _) = world.board.control.as_ref().unwrap();
        let (q, qd) = control.controller().commanded();
        (q[1], qd.iter().fold(0.0, |most: f32, speed| most.max(speed.abs())))
    };
    // Without torque the joint has sunk to an end of its range. The speed is 10 deg/s for any request, and the second
    // operator's button has no effect.
    for (operator, moves) in [(bob, false), (ann, true)] {
        let (before, mut most) = (place(&world).0, 0.0_f32);
        for _ in 0..50 {
            let now_us = world.now_us();
            world.host.stream(Stream::HoldToRun(operator), now_us);
            world.host.stream(Stream::Jog { dof: 1, velocity: -5.0 }, now_us);
            world.run(0.02);
            most = most.max(place(&world).1);
        }
        let moved = (place(&world).0 - before).abs();
        println!("{operator:?}: {moved:.3} rad in a second, at most {most:.3} rad/s");
        assert_eq!(moved > 0.05, moves);
        assert!(most <= 10.0_f32.to_radians() * 1.001);
    }
    // The button is released and the jog continues: the joint must stop 0.2 s later, plus its braking time.
    let mut stands = None;
    for step in 0..50 {
        let now_us = world.now_us();
        world.host.stream(Stream::Jog { dof: 1, velocity: -5.0 }, now_us);
        world.run(0.02);
        stands = stands.or((place(&world).1 < 1e-3).then_some(step));
    }
    let stands_s = 0.02 * f64::from(stands.unwrap() + 1);
    println!("stands {stands_s:.2} s after the button was released");
    assert!(stands_s <= 0.5 && place(&world).1 < 1e-3);
}

#[test]
fn a_second_host_is_refused_while_torque_is_on_but_may_stop() {
    let mut world = holding();
    let first = world.host.welcome.unwrap().session;
    let now_us = world.now_us();
    let hello = Hello { protocol: Version::CURRENT, nonce: 77 };
    world.host.send(&ToController::Hello(hello), now_us);
    world.run(0.1);
    assert_eq!((world.state(), world.host.welcome.unwrap().session), (Some(State::Holding), first));
    world.host.greet();
    world.run(0.1);
    let refused = world.host.welcome.unwrap();
    assert_eq!((refused.session, refused.verdict), (0, Err(Misfit::Busy)));
    // An emergency stop of any session is accepted.
    let stop = message::Numbered { session: 0, seq: 9, item: Command::EStop };
    let now_us = world.now_us();
    world.host.send(&ToController::Command(stop), now_us);
    world.run(0.01);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
}
