//! Newer settings, or a newer rig, that are damaged are not used, and the store reports it until intact ones are
//! written.

use sinew_storage::{Condition, Kind, Store};

use crate::common::flash::MockFlash;
use crate::common::{SMALL, content, everything, fault, put, rig};

fn open(flash: &mut MockFlash) -> (Store<&mut MockFlash>, sinew_storage::Disarmed) {
    Store::open(flash, SMALL).unwrap()
}

/// Creates a store with an old and a new item of a kind, with these contents.
fn two(kind: Kind, [old, new]: [&[u8]; 2]) -> MockFlash {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = open(&mut flash);
    put(&mut store, &disarmed, kind, old).unwrap();
    put(&mut store, &disarmed, kind, new).unwrap();
    flash
}

/// Returns settings or rig as bytes.
fn stored(store: &mut Store<&mut MockFlash>, kind: Kind) -> Option<Vec<u8>> {
    let all = everything(store);
    if kind == Kind::Rig { all.rig } else { all.settings }
}

fn damaged(store: &mut Store<&mut MockFlash>) -> [bool; 2] {
    [Kind::Settings, Kind::Rig].map(|kind| store.is_damaged(kind).unwrap())
}

/// If any bit of the newer item is flipped, except in its head (see the next test), the older item is used and the
/// damage is reported, also after a compaction and reopening. Writing the older item again clears the report.
#[test]
fn an_older_one_is_known_as_that_until_somebody_stands_for_it() {
    for kind in [Kind::Settings, Kind::Rig] {
        let contents = [rig(1, 2, 60), rig(2, 2, 60)];
        let base = two(kind, [&contents[0], &contents[1]]);
        // Head 16, descriptor 96, content 60, seal 4.
        let at = base.bytes.windows(60).position(|bytes| bytes == contents[1]).unwrap() - 96;
        for bit in 0..8 * (96 + 60 + 4) {
            let mut flash = base.clone();
            flash.bytes[at + bit / 8] ^= 1 << (bit % 8);
            let of_kind = [kind == Kind::Settings, kind == Kind::Rig];
            let (mut store, disarmed) = open(&mut flash);
            assert_eq!(damaged(&mut store), of_kind, "bit {bit}");
            assert_eq!(stored(&mut store, kind).unwrap(), contents[0]);
            // Two compactions: the note is copied. Only for some bits of each part, to limit the test's time.
            if bit % 97 == 0 {
                let mut number = 0;
                for _ in 0..2 {
                    while store.record_fault(&fault(number)).is_ok() {
                        number += 1;
                    }
                    store.tidy(&disarmed).unwrap();
                }
            }
            let (mut store, disarmed) = open(store.close());
            assert_eq!(damaged(&mut store), of_kind, "bit {bit}");
            put(&mut store, &disarmed, kind, &contents[0]).unwrap();
            let (mut store, _) = open(store.close());
            assert_eq!(damaged(&mut store), [false; 2], "bit {bit}");
            assert_eq!(stored(&mut store, kind).unwrap(), contents[0]);
        }
    }
}

/// If the head of a record is damaged, the store cannot find the records after that record, and reports settings and
/// rig as damaged.
#[test]
fn a_damaged_head_hides_what_is_behind_it() {
    let contents = [content(1, 60), content(2, 60)];
    let base = two(Kind::Settings, [&contents[0], &contents[1]]);
    let at = base.bytes.windows(60).position(|bytes| bytes == contents[1]).unwrap() - 96 - 16;
    for bit in 0..8 * 16 {
        let mut flash = base.clone();
        flash.bytes[at + bit / 8] ^= 1 << (bit % 8);
        let (mut store, disarmed) = open(&mut flash);
        assert_eq!(damaged(&mut store), [true; 2], "bit {bit}");
        assert_eq!(store.condition(), Condition::Untidy);
        store.tidy(&disarmed).unwrap();
        let (mut store, disarmed) = open(store.close());
        assert_eq!(damaged(&mut store), [true; 2], "bit {bit}");
        put(&mut store, &disarmed, Kind::Settings, &contents[1]).unwrap();
        put(&mut store, &disarmed, Kind::Rig, &rig(1, 2, 60)).unwrap();
        assert_eq!(damaged(&mut store), [false; 2], "bit {bit}");
    }
}

/// If damaged settings have no earlier ones, no settings are returned, and the damage is reported.
#[test]
fn the_only_ones_that_are_damaged_are_missed() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = open(&mut flash);
    assert_eq!(damaged(&mut store), [false; 2]);
    put(&mut store, &disarmed, Kind::Settings, b"some").unwrap();
    let at = flash.bytes.windows(4).position(|bytes| bytes == b"some").unwrap();
    flash.bytes[at] ^= 1;
    let (mut store, _) = open(&mut flash);
    assert_eq!((damaged(&mut store), stored(&mut store, Kind::Settings)), ([true, false], None));
}

/// An upload that a power cut interrupts before its seal is not reported as damage.
#[test]
fn what_was_never_sealed_is_not_missed() {
    let mut base = two(Kind::Settings, [b"old", b"older"]);
    let before = base.steps;
    let (mut store, disarmed) = open(&mut base);
    put(&mut store, &disarmed, Kind::Settings, &content(3, 90)).unwrap();
    let steps = base.steps - before;
    let mut told = 0;
    for seed in 0..3 {
        for cut in 0..steps {
            let mut flash = two(Kind::Settings, [b"old", b"older"]);
            flash.seed(seed);
            flash.power = Some(cut);
            let (mut store, disarmed) = open(&mut flash);
            assert!(put(&mut store, &disarmed, Kind::Settings, &content(3, 90)).is_err());
            flash.restart();
            let (mut store, _) = open(&mut flash);
            // The last word is the seal: cut before it, and within it.
            let is_damaged = damaged(&mut store)[0];
            assert!(!is_damaged || cut + 2 > steps, "cut at {cut} of {steps}");
            told += u32::from(is_damaged);
        }
    }
    println!("{told} of {} cuts look like damage", 3 * steps);
}
