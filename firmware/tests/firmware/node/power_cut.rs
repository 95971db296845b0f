//! Power fails at every step of flash, under a whole node. Afterwards either the old or the new data is in flash.

use sinew_link::message::{
    Applied, Command, FaultReport, Kind as ItemKind, Location, Outcome, Value,
};

use sinew_storage::Kind as Stored;

use super::flash::MockFlash;
use super::hardware::TABLE;
use super::line::Trouble;
use super::stored::{item, rig, settings, show};
use super::test_rig::Kind;
use super::world::World;

const KIND: Kind = Kind::Current;

/// All that a host can read of the stored data.
#[derive(Debug, PartialEq)]
struct Seen {
    setting: Outcome,
    items: [Outcome; 4],
    first_fault: Option<u8>,
    last_faults: u16,
}

fn look(world: &mut World) -> Seen {
    let places =
        [Location::Rig, Location::Settings, Location::Show { slot: 0 }, Location::Show { slot: 1 }];
    let setting = world.ask(Command::ReadSetting { key: 6 });
    let items = places.map(|place| world.ask(Command::AskStored(place)));
    let Outcome::Applied(Applied::Fault(FaultReport { count, record })) =
        world.ask(Command::ReadFault { index: 0 })
    else {
        panic!("no faults")
    };
    Seen { setting, items, first_fault: record.map(|record| record.fault), last_faults: count }
}

/// Runs an action with a power failure at every step, and checks the stored data each time.
fn cut_everywhere(base: &MockFlash, mut act: impl FnMut(&mut World)) {
    let mut world = World::new(KIND, Trouble::default(), 9);
    let begin = |world: &mut World, seed: u32| {
        let mut flash = base.clone();
        flash.seed(seed.into());
        *world.chip.flash.borrow_mut() = flash;
        assert!(world.restart());
        world.connect();
    };
    let again = |world: &mut World| {
        world.chip.flash.borrow_mut().restart();
        assert!(world.restart());
        world.connect();
    };
    begin(&mut world, 0);
    let old = look(&mut world);
    let before = world.chip.flash.borrow().steps;
    act(&mut world);
    let steps = world.chip.flash.borrow().steps - before;
    again(&mut world);
    let new = look(&mut world);
    assert_ne!(old, new);
    let (mut seen, mut asked) = ([0; 2], 0);
    // In the last pass power does not fail.
    for cut in 0..=steps {
        begin(&mut world, cut);
        world.chip.flash.borrow_mut().power = Some(cut);
        act(&mut world);
        again(&mut world);
        let found = look(&mut world);
        if is_damaged(&mut world) {
            // The cut was within the seal, where it cannot be distinguished from damage. The old items are there, and
            // are not used.
            assert_eq!((&found.setting, &found.items), (&old.setting, &old.items), "cut at {cut}");
            asked += 1;
            act(&mut world);
            again(&mut world);
            if is_damaged(&mut world) {
                // A single setting does not repair settings.
                let settings = settings(KIND).bytes();
                world.upload(&item(ItemKind::Settings, &settings, rig(KIND).1), &settings);
            }
            assert!(!is_damaged(&mut world), "cut at {cut}");
            continue;
        }
        assert!(found == old || found == new, "cut at {cut}: {found:?}");
        seen[usize::from(found == new)] += 1;
        if found == old {
            // The action continues where it was cut; an item that the cut has spoilt is written again.
            act(&mut world);
            act(&mut world);
            again(&mut world);
            assert_eq!(look(&mut world).items, new.items, "cut at {cut}");
        }
    }
    println!(
        "{steps} steps: old after {} cuts, new after {}, asked for after {asked}",
        seen[0], seen[1]
    );
    assert!(seen[0] > 0 && seen[1] > 0 && asked <= 1);
}

fn is_damaged(world: &mut World) -> bool {
    let store = world.board.background.store();
    [Stored::Settings, Stored::Rig].into_iter().any(|kind| store.is_damaged(kind).unwrap())
}

/// Returns the flash of a board that has a rig, a setting, a show, and a fault.
fn base() -> MockFlash {
    let old = show(KIND, 1, false);
    let mut world = World::ready(KIND, Trouble::default(), 9, &old);
    world.ask(Command::WriteSetting { key: 6, value: Value::Number(8.0) });
    world.connect();
    world.ask(Command::EStop);
    world.run(0.1);
    world.chip.flash.replace(MockFlash::new(&TABLE))
}

#[test]
fn a_setting_is_old_or_new() {
    cut_everywhere(&base(), |world| {
        world.ask(Command::WriteSetting { key: 6, value: Value::Number(9.0) });
    });
}

#[test]
fn a_fault_is_there_or_not() {
    cut_everywhere(&base(), |world| {
        world.ask(Command::EStop);
        world.run(0.02);
    });
}

#[test]
fn an_upload_is_old_or_new() {
    let (bytes, crc) = rig(KIND);
    let next = show(KIND, 1, true);
    let show_item = item(ItemKind::Show, &next, crc);
    cut_everywhere(&base(), |world| _ = world.upload(&show_item, &next));
    // An upload of the stored rig, approved by another person.
    let mut rig_item = item(ItemKind::Rig, &bytes, 0);
    rig_item.approver = "Grace, rigger".try_into().unwrap();
    cut_everywhere(&base(), |world| _ = world.upload(&rig_item, &bytes));
}

#[test]
fn changes_wear_the_log_evenly() {
    const CHANGES: u32 = 200;
    let mut world = World::ready(KIND, Trouble::default(), 9, &show(KIND, 1, false));
    for change in 0..CHANGES {
        let value = Value::Number(5.0 + change as f32 / 100.0);
        let changed = world.ask(Command::WriteSetting { key: 6, value: value.clone() });
        assert_eq!(changed, Outcome::Applied(Applied::Setting(value)));
        world.connect();
    }
    let flash = world.chip.flash.borrow();
    let erases = |start: usize| flash.erases.iter().find(|(at, _)| *at == start).unwrap().1;
    let log = [erases(0x4000), erases(0x8000)];
    println!("{CHANGES} changes of a setting erase the two sectors of the log {log:?} times");
    assert!(log[0].abs_diff(log[1]) <= 1 && log[0] + log[1] <= CHANGES / 20);
}
