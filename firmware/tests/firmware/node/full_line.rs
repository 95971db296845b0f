//! A host that sends but does not read, and a host that requests telemetry once in days.

use sinew_firmware::supervisor::State;
use sinew_link::message::{Command, Outcome, TelemetryParts, TelemetrySetting};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

fn telemetry(rate_hz: f32) -> Command {
    Command::SetTelemetry(TelemetrySetting { rate_hz, parts: TelemetryParts::ALL })
}

#[test]
fn an_emergency_stop_is_heard_while_nobody_reads() {
    let mut world = World::ready(KIND, Trouble::default(), 37, &show(KIND, 1, false));
    world.run(2.0);
    world.arm();
    world.until(State::Holding, 3.0);
    world.ask(telemetry(100.0));
    world.host.reads = false;
    // Heartbeats are received, too; whether the host receives is checked after 2 s.
    world.run(1.9);
    assert_eq!(world.state(), Some(State::Holding));
    let now_us = world.now_us();
    world.host.ask(Command::EStop, now_us);
    world.run(0.01);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
    // The host reads again, and asks again for the answer for which there was no room.
    world.host.reads = true;
    world.run(1.0);
    assert!(matches!(world.host.outcome, Some(Outcome::Applied(_))), "{:?}", world.host.outcome);
    assert!(world.host.faults.iter().all(|fault| fault.fault == 16), "{:?}", world.host.faults);
}

#[test]
fn a_slow_rate_does_not_silence_the_next_one() {
    let mut world = World::ready(KIND, Trouble::default(), 41, &show(KIND, 1, false));
    world.ask(telemetry(1e-6));
    world.run(0.1);
    world.ask(telemetry(20.0));
    let before = world.host.summaries.len();
    world.run(1.0);
    let count = world.host.summaries.len() - before;
    assert!((19..=22).contains(&count), "{count}");
}
