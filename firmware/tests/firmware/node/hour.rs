//! A looping show for an hour, in accelerated time.

use sinew_firmware::supervisor::State;
use sinew_link::message::{Command, Feed};
use sinew_servo_bus::ServoBus;

use super::ideal::Ideal;
use super::line::Trouble;
use super::stored::show;
use super::test_rig::{Kind, SERVOS};
use super::world::World;

/// Plays for a time, and returns the hash of all packets. Ticks take no time in this test: the test in `whole` counts
/// overruns.
fn play(seconds: u64) -> u64 {
    let kind = Kind::Position;
    let mut world = World::ready(kind, Trouble::default(), 3, &show(kind, 8, true));
    world.until(State::Limp, 3.0);
    let (_, bus) = world.board.control.as_ref().unwrap();
    let places = (0..SERVOS).map(|servo| bus.feedback(servo).unwrap().position_rad).collect();
    world.ideal = Some(Ideal(places));
    world.arm();
    world.until(State::Holding, 3.0);
    world.ask(Command::Play(Feed::Show));
    let sample = |world: &World| {
        let (control, _) = world.board.control.as_ref().unwrap();
        let controller = control.controller();
        let at = controller.report().show.unwrap().sample();
        controller.permission().runs.then_some(u64::from(at))
    };
    while sample(&world).is_none() {
        world.tick();
    }
    let rate_hz = u64::from(kind.rate_hz());
    let (begin, first) = (world.ticks, sample(&world).unwrap());
    for tick in 1..=seconds * rate_hz {
        world.tick();
        if tick % rate_hz == 0 {
            // The show has 100 samples per second of the board's clock.
            let by_clock = (world.ticks - begin) * 100 / rate_hz;
            let at = sample(&world).expect("it plays") - first;
            assert!(at.abs_diff(by_clock) <= 1, "sample {at}, by the clock {by_clock}");
        }
    }
    assert_eq!(world.state(), Some(State::Playing));
    assert!(world.host.faults.is_empty(), "{:?}", world.host.faults);
    world.hash
}

#[test]
fn an_hour_of_a_show_has_no_drift() {
    println!("one hour: hash {:016x}", play(3600));
}

#[test]
fn ten_minutes_have_the_same_hash_twice() {
    assert_eq!(play(600), play(600));
}
