//! A silent host: the rig holds after 200 ms and is lowered after 2 s; both times are settings.

use sinew_firmware::supervisor::State;
use sinew_link::message::{Command, Feed, Outcome, Value};

use super::line::Trouble;
use super::stored::show;
use super::test_rig::Kind;
use super::world::World;

/// Returns the seconds of silence until the rig holds, until its lowering begins, and until it is faulted.
fn silence(world: &mut World) -> [f64; 3] {
    world.until(State::Limp, 3.0);
    // Released at its home, the arm falls: it is armed when it hangs.
    world.run(1.0);
    world.arm();
    world.until(State::Holding, 3.0);
    world.ask(Command::Play(Feed::Show));
    world.run(3.0);
    assert_eq!(world.state(), Some(State::Playing));
    world.host.beats = false;
    // Messages in transit still arrive; no others are sent.
    let begin = world.now_us();
    [State::Holding, State::Lowering, State::Faulted].map(|state| {
        world.until(state, 20.0);
        (world.now_us() - begin) as f64 * 1e-6
    })
}

#[test]
fn a_silent_host_leads_to_hold_and_to_limp() {
    let show = show(Kind::Current, 20, false);
    let mut world = World::ready(Kind::Current, Trouble::default(), 5, &show);
    let [hold_s, lower_s, limp_s] = silence(&mut world);
    println!("hold after {hold_s:.4} s, lowered from {lower_s:.4} s, limp at {limp_s:.4} s");
    // The last heartbeat was sent up to 20 ms earlier; it takes up to three ticks of 2.5 ms from host to supervisor.
    assert!((0.18..=0.2076).contains(&hold_s), "{hold_s}");
    assert!((1.98..=2.0076).contains(&lower_s), "{lower_s}");
    // The arm hangs, or moves down: its weight fades for at least 3 s.
    assert!((3.0..=18.005).contains(&(limp_s - lower_s)), "{limp_s}");
    assert!(world.servos_on() == 0 && !world.pins.outputs);
    // The host returns: nothing moves, and the fault is reported and stored.
    world.connect();
    world.host.beats = true;
    world.run(1.0);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
    assert!(world.host.faults.iter().any(|fault| fault.fault == 2), "{:?}", world.host.faults);
    assert!(matches!(world.ask(Command::ClearFaults), Outcome::Applied(_)));
    assert_eq!(world.state(), Some(State::Limp));

    // The settings are changed to 0.5 s and 1 s.
    for (key, value) in [(1, 0.5), (2, 1.0)] {
        world.ask(Command::WriteSetting { key, value: Value::Number(value) });
        world.connect();
    }
    world.ask(Command::LoadShow { slot: 0 });
    let [hold_s, lower_s, _] = silence(&mut world);
    println!("with settings of 0.5 s and 1 s: {hold_s:.4} s, {lower_s:.4} s");
    assert!((0.48..=0.5076).contains(&hold_s) && (0.98..=1.0076).contains(&lower_s));
}
