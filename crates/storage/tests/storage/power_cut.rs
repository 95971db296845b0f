//! Power is cut at every write and within it: an operation has happened or has not, and the store remains usable.
#![expect(clippy::cast_possible_truncation, reason = "a small flash has small numbers")]
#![expect(
    clippy::redundant_closure_for_method_calls,
    reason = "a method's name has one lifetime, a closure any"
)]

use sinew_storage::{Condition, Disarmed, Kind, Store};

use crate::common::flash::MockFlash;
use crate::common::{
    Everything, Result, SMALL, content, everything, fault, is_on_page, put, rig, upload,
};

type Flash<'a> = Store<&'a mut MockFlash>;

/// Cuts the power at every step of an operation, with several random seeds. Asserts that the store then has its old or
/// its new content.
fn cut(name: &str, start: &MockFlash, operation: impl Fn(&mut Flash<'_>, &Disarmed) -> Result<()>) {
    let see =
        |flash: &MockFlash| everything(&mut Store::open(&mut flash.clone(), SMALL).unwrap().0);
    let old = see(start);
    let mut whole = start.clone();
    whole.steps = 0;
    let (mut store, disarmed) = Store::open(&mut whole, SMALL).unwrap();
    operation(&mut store, &disarmed).unwrap();
    let new = see(&whole);
    let (mut olds, mut news) = (0, 0);
    for seed in 0..3 {
        for step in 0..whole.steps {
            let mut flash = start.clone();
            flash.seed(seed * 1_000_003 + u64::from(step));
            flash.power = Some(step);
            let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
            assert!(operation(&mut store, &disarmed).is_err(), "{name}: no cut at step {step}");
            flash.restart();
            let found = see(&flash);
            assert!(found == old || found == new, "{name}, cut at step {step}: {found:?}");
            (olds, news) = (olds + u32::from(found == old), news + u32::from(found == new));
            check_usable(&mut flash, &found, &new, &operation);
        }
    }
    // If old and new items are equal, only the bytes differ.
    let after = if old == new { "the same".into() } else { format!("{olds} old, {news} new") };
    is_on_page(&[format!("| {name} | {} | {after} |", whole.steps * 3)]);
}

/// Checks a store after the cut: it can be tidied and has the items that were found; the operation, if it had no
/// effect, can be repeated; and a fault can be recorded.
fn check_usable(
    flash: &mut MockFlash,
    found: &Everything,
    new: &Everything,
    operation: &impl Fn(&mut Flash<'_>, &Disarmed) -> Result<()>,
) {
    let (mut store, disarmed) = Store::open(&mut *flash, SMALL).unwrap();
    store.tidy(&disarmed).unwrap();
    assert_eq!(store.condition(), Condition::Good);
    assert_eq!(&everything(&mut store), found);
    if found != new {
        operation(&mut store, &disarmed).unwrap();
        assert_eq!(&everything(&mut store), new);
    }
    store.tidy(&disarmed).unwrap();
    store.record_fault(&fault(999)).unwrap();
    assert_eq!(store.faults().unwrap().last.back().unwrap().number, 999);
}

/// Creates a store with settings, a rig, a show and two faults, after a number of changes of the settings.
fn used(changes: u32) -> MockFlash {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    put(&mut store, &disarmed, Kind::Rig, &rig(1, 2, 300)).unwrap();
    upload(&mut store, &disarmed, Kind::Show, &content(1, 900), 256).unwrap();
    store.record_fault(&fault(1)).unwrap();
    store.clear_faults().unwrap();
    store.record_fault(&fault(2)).unwrap();
    for change in 0..changes {
        put(&mut store, &disarmed, Kind::Settings, &content(change, 90)).unwrap();
    }
    flash
}

/// Returns a flash on which the next change of settings must compact the log.
fn full() -> MockFlash {
    let erases = |flash: &MockFlash| flash.erases.iter().map(|(_, count)| count).sum::<u32>();
    let first = erases(&used(0));
    let changes = (0..1000).find(|changes| erases(&used(changes + 1)) > first).unwrap();
    used(changes)
}

#[test]
fn the_first_settings_of_a_blank_board() {
    cut("the first settings of a blank board", &MockFlash::new(&SMALL), |store, disarmed| {
        put(store, disarmed, Kind::Settings, &content(7, 90)).map(drop)
    });
}

#[test]
fn a_change_of_settings() {
    cut("a change of settings", &used(2), |store, disarmed| {
        put(store, disarmed, Kind::Settings, &content(1000, 90)).map(drop)
    });
}

#[test]
fn a_change_of_settings_that_fills_the_sector() {
    cut("a change of settings for which the log is compacted", &full(), |store, disarmed| {
        put(store, disarmed, Kind::Settings, &content(1000, 90)).map(drop)
    });
}

#[test]
fn the_upload_of_a_rig() {
    cut("an upload of a rig by 4 blocks", &used(2), |store, disarmed| {
        upload(store, disarmed, Kind::Rig, &rig(2, 3, 401), 128).map(drop)
    });
}

#[test]
fn the_upload_of_a_show() {
    cut("an upload of a show by 4 blocks", &used(2), |store, disarmed| {
        upload(store, disarmed, Kind::Show, &content(2, 1001), 256).map(drop)
    });
}

#[test]
fn the_end_of_a_show() {
    cut("a show is deleted", &used(2), |store, disarmed| store.delete_show(disarmed, 0));
}

#[test]
fn a_fault() {
    cut("a fault is recorded", &used(2), |store, disarmed| match store.record_fault(&fault(77)) {
        // The power cut was within a record's head.
        Err(sinew_storage::Error::Untidy) => {
            store.tidy(disarmed)?;
            store.record_fault(&fault(77)).map(drop)
        }
        result => result.map(drop),
    });
}

#[test]
fn faults_cleared() {
    cut("faults are cleared", &used(2), |store, _| store.clear_faults());
}

#[test]
fn faults_that_fill_the_sector() {
    let mut flash = used(3);
    let (mut store, _) = Store::open(&mut flash, SMALL).unwrap();
    let recorded =
        (3..1000).take_while(|number| store.record_fault(&fault(*number)).is_ok()).count();
    assert!(recorded > 20 && store.condition() == Condition::Untidy);
    let seen = everything(&mut store);
    assert_eq!((seen.first_fault, seen.last_faults.len()), (Some(2), 16));
    cut("the log is tidied", &flash, |store, disarmed| store.tidy(disarmed));
}

/// Performs random operations, with a power failure in most of them, and compares the stored content with a model of
/// the possible content.
#[test]
fn long_lives_with_many_cuts() {
    for life in 0..40_u32 {
        let mut flash = MockFlash::new(&SMALL);
        flash.seed(u64::from(life));
        let mut old = everything(&mut Store::open(&mut flash, SMALL).unwrap().0);
        for number in 1..60 {
            let (which, steps) = (flash.random() % 7, flash.random() % 900);
            flash.power = (!flash.random().is_multiple_of(4)).then_some(steps as u32);
            let mut new = old.clone();
            let done = match Store::open(&mut flash, SMALL) {
                Ok((mut store, disarmed)) => live(&mut store, &disarmed, which, number, &mut new),
                Err(_) => unreachable!("opening takes no step"),
            };
            flash.restart();
            let found = everything(&mut Store::open(&mut flash, SMALL).unwrap().0);
            if done.is_ok() {
                assert_eq!(found, new, "life {life}, operation {number}");
            } else {
                assert!(found == old || found == new, "life {life}, operation {number}: {found:?}");
            }
            old = found;
        }
    }
}

/// Performs an operation, and updates the model of the possible content.
fn live(
    store: &mut Flash<'_>,
    disarmed: &Disarmed,
    which: u64,
    number: u32,
    new: &mut Everything,
) -> Result<()> {
    store.tidy(disarmed)?;
    match which {
        0 | 1 => {
            let settings = content(number, 50 + number as usize);
            new.settings = Some(settings.clone());
            put(store, disarmed, Kind::Settings, &settings).map(drop)
        }
        2 => {
            let bytes = rig(number, 3, 100 + 5 * number as usize);
            new.rig = Some(bytes.clone());
            upload(store, disarmed, Kind::Rig, &bytes, 64).map(drop)
        }
        3 => {
            let show = content(number, 700 + number as usize);
            let Some(slot) = new.shows.iter().position(Option::is_none) else { return Ok(()) };
            new.shows[slot] = Some(show.clone());
            upload(store, disarmed, Kind::Show, &show, 128).map(drop)
        }
        4 => {
            let slot = (number % 2) as usize;
            new.shows[slot] = None;
            store.delete_show(disarmed, slot)
        }
        5 => {
            new.first_fault = None;
            store.clear_faults()
        }
        _ => {
            let number = u16::try_from(number).unwrap();
            new.first_fault = new.first_fault.or(Some(number));
            new.last_faults.push(number);
            if new.last_faults.len() > 16 {
                new.last_faults.remove(0);
            }
            store.record_fault(&fault(number)).map(drop)
        }
    }
}
