//! With a rig, settings and a show that do not fit together, or are bad, nothing moves.

use sinew_firmware::supervisor::State;
use sinew_link::message::{
    Applied, Command, Item, Kind as ItemKind, Location, Outcome, Refusal, Value,
};

use super::line::Trouble;
use super::stored::{item, rig, settings, show};
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

fn ready() -> World {
    World::ready(KIND, Trouble::default(), 17, &show(KIND, 1, false))
}

#[test]
fn a_show_of_another_rig_is_refused() {
    let mut world = ready();
    let other = show(Kind::Position, 1, false);
    let (mine, theirs) = (rig(KIND).1, rig(Kind::Position).1);
    let refused = Outcome::Refused(Refusal::OtherRig { show: theirs, rig: mine });
    assert_eq!(world.upload(&item(ItemKind::Show, &other, theirs), &other), refused);
    // This is also refused if its item names another rig than its content.
    assert_eq!(world.upload(&item(ItemKind::Show, &other, mine), &other), refused);
    assert_eq!(world.ask(Command::LoadShow { slot: 1 }), Outcome::Refused(Refusal::Unknown));
}

#[test]
fn settings_of_the_rig_before_refuse_motion() {
    let mut world = ready();
    let settings = settings(KIND).bytes();
    let of_old = item(ItemKind::Settings, &settings, rig(KIND).1);
    world.upload(&of_old, &settings);
    world.connect();
    let (bytes, crc) = rig(Kind::Position);
    world.upload(&item(ItemKind::Rig, &bytes, 0), &bytes);
    world.connect();
    assert_eq!(world.host.welcome.unwrap().about.rig, crc);
    world.run(1.0);
    assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
    assert_eq!(world.ask(Command::Arm), Outcome::Refused(Refusal::Fault(13)));
    assert_eq!(world.ask(Command::ClearFaults), Outcome::Refused(Refusal::NeedsUpload(13)));
    // A single setting would make the other rig's settings valid for this rig.
    let one = Command::WriteSetting { key: 6, value: Value::Number(8.0) };
    assert_eq!(world.ask(one), Outcome::Refused(Refusal::NeedsUpload(13)));
    assert!(world.restart());
    world.connect();
    world.run(1.0);
    assert_eq!(world.state(), Some(State::Faulted));
    // Good settings for this rig clear the fault.
    world.upload(&item(ItemKind::Settings, &settings, crc), &settings);
    world.connect();
    world.until(State::Limp, 2.0);
}

#[test]
fn a_rig_that_flash_has_lost_refuses_motion() {
    let mut world = ready();
    // Damages the position of the first servo in every copy in the log.
    let (bytes, _) = rig(KIND);
    let mut flash = world.chip.flash.borrow_mut();
    let copies: Vec<usize> =
        (0x4000..0xC000).filter(|at| flash.bytes[*at..].starts_with(&bytes)).collect();
    assert!(!copies.is_empty());
    for at in copies {
        flash.bytes[at + 100] ^= 0x10;
    }
    drop(flash);
    assert!(world.restart());
    world.connect();
    assert_eq!((world.state(), world.host.welcome.unwrap().about.rig), (None, 0));
    assert_eq!(world.ask(Command::Arm), Outcome::Refused(Refusal::Fault(13)));
}

/// The newest settings are damaged and the previous ones are complete. Every start then reads the previous settings,
/// but reports a fault that prevents arming, until somebody approves settings again. These may be the same as the
/// previous ones.
#[test]
fn older_settings_do_not_count_where_newer_ones_are_damaged() {
    let mut world = ready();
    for value in [8.0, 9.0] {
        world.ask(Command::WriteSetting { key: 6, value: Value::Number(value) });
        world.connect();
    }
    // A bit of the newest settings: key 6 with 9 s.
    let key: Vec<u8> = 6_u16.to_le_bytes().into_iter().chain(9_f32.to_le_bytes()).collect();
    let mut flash = world.chip.flash.borrow_mut();
    let at = flash.bytes.windows(key.len()).rposition(|bytes| bytes == key).unwrap();
    flash.bytes[at + 2] ^= 0x10;
    drop(flash);
    for _ in 0..2 {
        assert!(world.restart());
        world.connect();
        world.run(1.0);
        let told = world.ask(Command::ReadSetting { key: 6 });
        assert_eq!(told, Outcome::Applied(Applied::Setting(Value::Number(8.0))));
        assert_eq!((world.state(), world.servos_on()), (Some(State::Faulted), 0));
        assert_eq!(world.host.faults.last().unwrap().fault, 13);
        assert_eq!(world.ask(Command::Arm), Outcome::Refused(Refusal::Fault(13)));
        assert_eq!(world.ask(Command::ClearFaults), Outcome::Refused(Refusal::NeedsUpload(13)));
        let one = Command::WriteSetting { key: 6, value: Value::Number(8.0) };
        assert_eq!(world.ask(one), Outcome::Refused(Refusal::NeedsUpload(13)));
    }
    // The older settings, bit for bit, with their descriptor.
    let settings = settings(KIND).with(6, 8.0).unwrap().bytes();
    let mut same = item(ItemKind::Settings, &settings, rig(KIND).1);
    same.approver = "host, one setting".try_into().unwrap();
    assert_eq!(world.ask(Command::AskStored(Location::Settings)), stored(&same));
    assert_eq!(world.upload(&same, &settings), stored(&same));
    world.connect();
    world.until(State::Limp, 2.0);
}

fn stored(item: &Item) -> Outcome {
    Outcome::Applied(Applied::Stored(Some(item.clone())))
}

#[test]
fn what_cannot_be_used_does_not_replace_what_can() {
    let mut world = ready();
    let (good, crc) = rig(KIND);
    let mut bad = good.clone();
    bad[200] ^= 0xFF;
    let upload = |world: &mut World, item: &Item, content: &[u8]| world.upload(item, content);
    let refused = upload(&mut world, &item(ItemKind::Rig, &bad, 0), &bad);
    assert!(matches!(refused, Outcome::Refused(Refusal::Content(5))), "{refused:?}");
    let settings = [1, 0, 0, 0, 192, 127];
    let refused = upload(&mut world, &item(ItemKind::Settings, &settings, crc), &settings);
    assert_eq!(refused, Outcome::Refused(Refusal::Value));
    // The declared hash is not that of the content.
    let mut lie = item(ItemKind::Rig, &good, 0);
    lie.hash[0] ^= 1;
    assert_eq!(upload(&mut world, &lie, &good), Outcome::Refused(Refusal::Hash));
    assert!(world.restart());
    world.connect();
    assert_eq!(world.host.welcome.unwrap().about.rig, crc);
}
