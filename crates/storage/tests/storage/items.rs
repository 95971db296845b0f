//! Items and uploads: accepted content, refused content, and the continuation of uploads.
#![expect(clippy::cast_possible_truncation, reason = "a small flash has small numbers")]

use sinew_rig::board::{BoardRig, BoardRigError};
use sinew_storage::{
    Approver, Area, BoardTable, Capacity, CapacityError, Condition, Descriptor, Error, FAULTS_KEPT,
    Hash, Kind, Store, TableError,
};

use crate::common;
use crate::common::flash::{MockFlash, PowerFailed};
use crate::common::{SMALL, approver, content, describe, everything, fault, put, rig, upload};

#[test]
fn items_are_read_back_in_place_and_by_block() {
    let mut flash = MockFlash::new(&SMALL);
    let show = content(3, 1234);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    assert_eq!(store.condition(), Condition::New);
    assert_eq!(everything(&mut store).shows, [None, None]);
    upload(&mut store, &disarmed, Kind::Show, &show, 512).unwrap();
    put(&mut store, &disarmed, Kind::Settings, &content(4, 77)).unwrap();
    let item = store.show(0).unwrap().unwrap();
    let mut block = [0; 100];
    store.read(&item, 1001, &mut block).unwrap();
    assert_eq!(block, show[1001..1101]);
    let beyond = store.read(&item, 1201, &mut block);
    assert_eq!(beyond, Err(Error::Beyond { found: 1301, len: 1234 }));
    assert_eq!(item.descriptor(), &describe(Kind::Show, &show));
    assert_eq!(item.descriptor().approver.name(), "Ada, stage manager");
    assert!(item.descriptor().check_schema(1).is_ok());
    let other = item.descriptor().check_schema(2).unwrap_err();
    assert_eq!(other.to_string(), "Show is of schema 1; this firmware reads 2");
    // Reads the content from flash that is mapped as memory.
    assert_eq!(item.content(&flash.bytes), Some(&show[..]));
    assert_eq!(item.content(&flash.bytes[..0x4100]), None);
}

#[test]
fn an_upload_goes_on_where_it_was_cut() {
    let show = content(5, 1500);
    let descriptor = describe(Kind::Show, &show);
    for cut_at in [0, 256, 1024, 1280] {
        let mut flash = MockFlash::new(&SMALL);
        let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
        let mut upload = store.begin(&disarmed, &descriptor).unwrap();
        for from in (0..cut_at).step_by(256) {
            let block = &show[from..from + 256];
            store.write(&disarmed, &mut upload, from as u32, block).unwrap();
            // The answer was lost, and the host repeats the block.
            store.write(&disarmed, &mut upload, from as u32, block).unwrap();
        }
        let erases = flash.erases.clone();
        let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
        assert_eq!(store.show(0).unwrap(), None);
        let mut upload = store.begin(&disarmed, &descriptor).unwrap();
        let from = upload.received() as usize;
        // At most the last chunk is repeated.
        assert!(from <= cut_at && from + 64 >= cut_at, "{from} of {cut_at}");
        store.write(&disarmed, &mut upload, from as u32, &show[from..]).unwrap();
        let item = store.end(&disarmed, &upload).unwrap();
        assert_eq!(common::read(&mut store, &item), show);
        // A complete upload is found when it is started again.
        let again = store.begin(&disarmed, &descriptor).unwrap();
        assert_eq!(again.received(), 1500);
        assert_eq!(store.end(&disarmed, &again), Ok(item));
        assert_eq!(flash.erases, erases);
    }
}

#[test]
fn blocks_in_the_wrong_place_are_refused_and_nothing_is_lost() {
    let show = content(5, 1001);
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    let mut upload = store.begin(&disarmed, &describe(Kind::Show, &show)).unwrap();
    store.write(&disarmed, &mut upload, 0, &show[..64]).unwrap();
    let order = store.write(&disarmed, &mut upload, 128, &show[128..192]);
    assert_eq!(order, Err(Error::Order { expected: 64, found: 128 }));
    let odd = store.write(&disarmed, &mut upload, 64, &show[64..70]);
    assert_eq!(odd, Err(Error::Alignment { granule: 4, offset: 64, len: 6 }));
    let odd = store.write(&disarmed, &mut upload, 62, &show[62..66]);
    assert_eq!(odd, Err(Error::Alignment { granule: 4, offset: 62, len: 4 }));
    let beyond = store.write(&disarmed, &mut upload, 64, &content(1, 1000));
    assert_eq!(beyond, Err(Error::Beyond { found: 1064, len: 1001 }));
    let early = store.end(&disarmed, &upload);
    assert_eq!(early, Err(Error::Order { expected: 64, found: 1001 }));
    store.write(&disarmed, &mut upload, 64, &show[64..]).unwrap();
    store.end(&disarmed, &upload).unwrap();
}

#[test]
fn content_of_another_hash_is_dropped() {
    for kind in [Kind::Settings, Kind::Show] {
        let mut flash = MockFlash::new(&SMALL);
        let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
        put(&mut store, &disarmed, kind, &content(1, 200)).unwrap();
        let before = everything(&mut store);
        let announced = describe(kind, &content(2, 300));
        let other = store.put(&disarmed, &announced, &content(3, 300));
        assert_eq!(other, Err(Error::Hash));
        assert_eq!(everything(&mut store), before);
        // The right content starts again.
        assert_eq!(store.begin(&disarmed, &announced).unwrap().received(), 0);
        store.put(&disarmed, &announced, &content(2, 300)).unwrap();
        assert_ne!(everything(&mut store), before);
    }
}

#[test]
fn an_upload_notices_that_its_place_is_gone() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    let bytes = rig(1, 2, 400);
    let mut upload = store.begin(&disarmed, &describe(Kind::Rig, &bytes)).unwrap();
    for number in 0..20 {
        put(&mut store, &disarmed, Kind::Settings, &content(number, 100)).unwrap();
    }
    assert_eq!(store.write(&disarmed, &mut upload, 0, &bytes), Err(Error::Stale));
    assert_eq!(store.end(&disarmed, &upload), Err(Error::Stale));
    let show = content(5, 600);
    let mut upload = store.begin(&disarmed, &describe(Kind::Show, &show)).unwrap();
    store.write(&disarmed, &mut upload, 0, &show).unwrap();
    store.delete_show(&disarmed, 0).unwrap();
    assert_eq!(store.end(&disarmed, &upload), Err(Error::Stale));
    assert_eq!(store.show(0), Ok(None));
}

#[test]
fn no_show_is_overwritten() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    for number in 0..2 {
        put(&mut store, &disarmed, Kind::Show, &content(number, 900)).unwrap();
    }
    let third = put(&mut store, &disarmed, Kind::Show, &content(2, 900));
    assert_eq!(third, Err(Error::NoFreeSlot { len: 900 }));
    let long = put(&mut store, &disarmed, Kind::Show, &content(2, 3000));
    assert_eq!(long, Err(Error::TooLong { len: 3000, holds: 2048 - 16 - 96 - 4 }));
    assert_eq!(store.show(2), Err(Error::Slot { slot: 2, slots: 2 }));
    store.delete_show(&disarmed, 1).unwrap();
    put(&mut store, &disarmed, Kind::Show, &content(2, 900)).unwrap();
    let shows = everything(&mut store).shows;
    assert_eq!(shows, [Some(content(0, 900)), Some(content(2, 900))]);
}

#[test]
fn the_same_again_writes_nothing() {
    let mut flash = MockFlash::new(&SMALL);
    for _ in 0..3 {
        let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
        put(&mut store, &disarmed, Kind::Settings, &content(1, 99)).unwrap();
        put(&mut store, &disarmed, Kind::Show, &content(1, 99)).unwrap();
        let steps = flash.steps;
        let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
        put(&mut store, &disarmed, Kind::Settings, &content(1, 99)).unwrap();
        put(&mut store, &disarmed, Kind::Show, &content(1, 99)).unwrap();
        assert_eq!(flash.steps, steps);
    }
}

#[test]
fn a_rig_that_is_too_large_is_refused_by_number() {
    let description = sinew_rig::new::arm(6).unwrap();
    let mechanism = description.mechanism().unwrap();
    let baked = BoardRig::<7, 6, 6>::bake(&description, &mechanism).unwrap();
    let mut bytes = vec![0; 4096];
    let len = baked.encode(&mut bytes).unwrap();
    bytes.truncate(len);
    let head: &[u8; Capacity::HEAD_LEN] = bytes.first_chunk().unwrap();
    // Bytes as `sinew-rig` itself encodes them.
    macro_rules! refused {
        ($bodies:literal, $dofs:literal, $servos:literal) => {{
            let capacity = Capacity { bodies: $bodies, dofs: $dofs, servos: $servos };
            let theirs = BoardRig::<$bodies, $dofs, $servos>::decode(&bytes).map(drop);
            match (capacity.check(head), theirs) {
                (Ok(()), Ok(())) => false,
                (
                    Err(CapacityError::TooLarge { what, found, holds }),
                    Err(BoardRigError::Capacity { what: theirs, found: count, holds: room }),
                ) => {
                    assert_eq!(
                        (what, usize::from(found), usize::from(holds)),
                        (theirs, count, room)
                    );
                    true
                }
                others => panic!("{others:?}"),
            }
        }};
    }
    assert!(!refused!(7, 6, 6) && refused!(6, 6, 6) && refused!(7, 5, 6) && refused!(7, 6, 5));

    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    let too_large = Error::Capacity(CapacityError::TooLarge { what: "bodies", found: 7, holds: 4 });
    // At the first block, or at the end if blocks are shorter than the checked part.
    for block in [4, 64] {
        assert_eq!(upload(&mut store, &disarmed, Kind::Rig, &bytes, block), Err(too_large));
    }
    assert_eq!(too_large.to_string(), "the rig has 7 bodies, the board holds 4");
    let none = put(&mut store, &disarmed, Kind::Rig, b"SNWR");
    assert!(matches!(none, Err(Error::Capacity(CapacityError::NotARig { .. }))));
    assert_eq!(store.rig(), Ok(None));
}

#[test]
fn faults_are_recorded_without_an_erase_and_the_first_stays() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    // Without a log the store does not record a fault.
    assert_eq!(store.record_fault(&fault(1)), Err(Error::Untidy));
    let mut last = 0;
    for run in 1..=5 {
        store.tidy(&disarmed).unwrap();
        // Armed from now on: a tidy log has room for the number of faults that are kept.
        for _ in 0..FAULTS_KEPT {
            last += 1;
            assert_eq!(store.record_fault(&fault(last)), Ok(run));
        }
        let faults = store.faults().unwrap();
        assert_eq!(faults.first, Some(sinew_storage::Fault { run: 1, ..fault(1) }));
        let numbers: Vec<u16> = faults.last.iter().map(|fault| fault.number).collect();
        assert_eq!(numbers, (last - 15..=last).collect::<Vec<_>>());
        store = Store::open(store.close(), SMALL).unwrap().0;
    }
    store.clear_faults().unwrap();
    assert_eq!(store.faults().unwrap().first, None);
    store.tidy(&disarmed).unwrap();
    store.record_fault(&fault(200)).unwrap();
    assert_eq!(store.faults().unwrap().first.unwrap().number, 200);
    assert_eq!(store.faults().unwrap().last.len(), FAULTS_KEPT);
}

#[test]
fn a_fault_keeps_every_number() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    store.tidy(&disarmed).unwrap();
    let odd = sinew_storage::Fault {
        run: 1,
        time_us: u64::MAX,
        number: u16::MAX,
        part: None,
        state: u8::MAX,
        times: u16::MAX,
    };
    store.record_fault(&odd).unwrap();
    assert_eq!(store.faults().unwrap().first, Some(odd));
    assert_eq!(store.run(), 1);
}

#[test]
fn the_largest_rig_can_be_replaced_and_a_larger_one_cannot() {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    let largest = SMALL.largest_rig::<MockFlash>(90) as usize;
    for number in 0..30 {
        put(&mut store, &disarmed, Kind::Settings, &content(number, 90)).unwrap();
        put(&mut store, &disarmed, Kind::Rig, &rig(number, 3, largest)).unwrap();
        store.tidy(&disarmed).unwrap();
        for _ in 0..number % 17 {
            store.record_fault(&fault(3)).unwrap();
        }
    }
    let full = put(&mut store, &disarmed, Kind::Rig, &rig(99, 3, largest + 9));
    assert!(matches!(full, Err(Error::Full { .. })), "{full:?}");
    assert_eq!(everything(&mut store).rig, Some(rig(29, 3, largest)));
}

#[test]
fn names_and_hashes() {
    assert_eq!(Approver::new("").unwrap_err().len, 0);
    assert!(Approver::new(&"é".repeat(30)).is_ok());
    assert_eq!(Approver::new(&"é".repeat(31)).unwrap_err().len, 62);
    assert!(Approver::new("two\nlines").is_err() && Approver::new("nul\0").is_err());
    // FIPS 180-2, appendix B.1.
    let abc = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";
    assert_eq!(Hash::of(b"abc").to_string(), abc);
    assert_eq!(Descriptor::of(Kind::Show, 2, b"abc", 0, approver()).len, 3);
}

#[test]
fn tables_that_do_not_fit_are_refused() {
    const SHORT: Area = Area { start: 0x1000, sector_len: 0x1000, sectors: 1 };
    let refused = |board: BoardTable| -> TableError {
        match Store::open(&mut MockFlash::new(&SMALL), board).map(drop) {
            Err(Error::Table(error)) => error,
            other => panic!("{other:?}"),
        }
    };
    let error = refused(BoardTable { log: SHORT, ..SMALL });
    assert_eq!(error, TableError::Sectors { start: 0x1000, found: 1, least: 2 });
    let odd = Area { start: 0x1010, ..SMALL.log };
    let error = refused(BoardTable { log: odd, ..SMALL });
    assert_eq!(error, TableError::Sector { start: 0x1010, sector_len: 0x1000, least: 1528 });
    let small = Area { sector_len: 0x400, ..SMALL.log };
    let error = refused(BoardTable { log: small, ..SMALL });
    assert_eq!(error, TableError::Sector { start: 0x1000, sector_len: 0x400, least: 1528 });
    let error = refused(BoardTable { slots: &[Area { start: 0x3000, ..SHORT }], ..SMALL });
    assert_eq!(error, TableError::Overlap { first: 0x1000, second: 0x3000 });
    let long = Area { sectors: u32::MAX, ..SMALL.log };
    assert!(matches!(refused(BoardTable { log: long, ..SMALL }), TableError::Beyond { .. }));
    let _: Error<PowerFailed> = Error::Table(error);
}
