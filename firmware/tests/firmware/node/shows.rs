//! Permission to change flash: commands that arrive faster than the loop handles them.

use sinew_firmware::supervisor::State;
use sinew_link::message::{
    self, Command, Feed, Kind as ItemKind, Outcome, Refusal, ToController, Value,
};

use super::line::Trouble;
use super::stored::{item, rig, show};
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

fn ready() -> World {
    World::ready(KIND, Trouble::default(), 31, &show(KIND, 20, true))
}

/// Sends commands that all arrive in one tick. Afterwards the host must connect again: their numbers are far ahead of
/// its own.
fn at_once(world: &mut World, commands: &[Command]) {
    let session = world.host.welcome.unwrap().session;
    let now_us = world.now_us();
    for (seq, item) in (1000..).zip(commands) {
        let command = message::Numbered { session, seq, item: item.clone() };
        world.host.send(&ToController::Command(command), now_us);
    }
    world.run(0.1);
}

#[test]
fn a_show_stays_while_the_loop_may_read_it() {
    let mut world = ready();
    // Another show is uploaded; the loop releases the first.
    let (other, crc) = (show(KIND, 1, false), rig(KIND).1);
    world.upload(&item(ItemKind::Show, &other, crc), &other);
    let load = |slot| Command::LoadShow { slot };
    let delete = |slot| Command::DeleteShow { slot };
    let begin = Command::BeginUpload(item(ItemKind::Show, &show(KIND, 2, false), crc));
    // The chip panics if a show changes while the loop reads it. Without the protection, the second command would be
    // executed.
    at_once(&mut world, &[load(1), delete(1), begin]);
    world.connect();
    at_once(&mut world, &[delete(1), load(1)]);
    world.connect();
    assert!(matches!(world.ask(load(0)), Outcome::Applied(_)));
    assert_eq!(world.ask(load(1)), Outcome::Refused(Refusal::Unknown));
}

#[test]
fn a_show_that_plays_is_not_deleted_and_plays_on() {
    let mut world = ready();
    world.run(2.0);
    world.arm();
    world.until(State::Holding, 3.0);
    world.ask(Command::Play(Feed::Show));
    world.run(1.0);
    let refused = Outcome::Refused(Refusal::State(message::State::Playing));
    assert_eq!(world.ask(Command::DeleteShow { slot: 0 }), refused);
    world.run(1.0);
    assert_eq!(world.state(), Some(State::Playing), "{:?}", world.host.faults);
}

#[test]
fn nobody_arms_between_a_setting_and_its_restart() {
    let mut world = ready();
    world.run(2.0);
    assert_eq!((world.state(), world.starts), (Some(State::Limp), 2));
    let setting = Command::WriteSetting { key: 6, value: Value::Number(8.0) };
    // The outbox is not empty, so the restart waits.
    world.host.reads = false;
    at_once(&mut world, &[Command::Arm, setting]);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Limp), 0));
    world.host.reads = true;
    world.run(0.1);
    assert_eq!(world.starts, 3);
    world.connect();
    let eight = Outcome::Applied(message::Applied::Setting(Value::Number(8.0)));
    assert_eq!(world.ask(Command::ReadSetting { key: 6 }), eight);
}
