//! Flash with any content: nothing panics, no invalid content is accepted, and the store remains usable.
#![expect(clippy::cast_possible_truncation, reason = "a small flash has small numbers")]

use proptest::prelude::*;
use sinew_storage::{Condition, Kind, Store};

use crate::common::flash::MockFlash;
use crate::common::{SMALL, content, everything, fault, put, rig};

/// Computes CRC-32 (ISO-HDLC) bit by bit, independently of the product's table.
fn crc(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, byte| {
        (0..8).fold(crc ^ u32::from(*byte), |crc, _| {
            (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg())
        })
    })
}

/// Returns the flash of a used store, and the contents of all items that were ever written to it.
fn used() -> (MockFlash, Vec<Vec<u8>>) {
    let mut flash = MockFlash::new(&SMALL);
    let (mut store, disarmed) = Store::open(&mut flash, SMALL).unwrap();
    let mut written = Vec::new();
    let mut keep = |store: &mut Store<&mut MockFlash>, kind, bytes: Vec<u8>| {
        put(store, &disarmed, kind, &bytes).unwrap();
        written.push(bytes);
    };
    for number in 0..30 {
        keep(&mut store, Kind::Settings, content(number, 90));
        keep(&mut store, Kind::Rig, rig(number, 3, 200));
        store.record_fault(&fault(u16::try_from(number).unwrap())).unwrap();
    }
    for number in 0..2 {
        keep(&mut store, Kind::Show, content(number, 1000));
    }
    (flash, written)
}

/// Reads everything, and uses the store normally.
fn go_on(flash: &mut MockFlash, is_good: impl Fn(&[u8]) -> bool) {
    let (mut store, disarmed) = Store::open(&mut *flash, SMALL).unwrap();
    let found = everything(&mut store);
    for item in found.shows.iter().chain([&found.settings, &found.rig]).flatten() {
        assert!(is_good(item), "{item:?}");
    }
    assert!(
        store
            .faults()
            .unwrap()
            .last
            .iter()
            .all(|fault| fault.time_us == u64::from(fault.number) * 1000)
    );
    let _ = store.record_fault(&fault(7));
    store.tidy(&disarmed).unwrap();
    assert_eq!(store.condition(), Condition::Good);
    put(&mut store, &disarmed, Kind::Settings, b"new").unwrap();
    store.record_fault(&fault(8)).unwrap();
    store.delete_show(&disarmed, 1).unwrap();
    put(&mut store, &disarmed, Kind::Show, b"new show").unwrap();
    let (mut store, _) = Store::open(&mut *flash, SMALL).unwrap();
    let found = everything(&mut store);
    assert_eq!(found.settings.unwrap(), b"new");
    assert!(found.shows.contains(&Some(b"new show".to_vec())));
    assert_eq!(found.last_faults.last(), Some(&8));
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes_are_nothing(seed in any::<u64>(), density in 0_u8..4) {
        let mut flash = MockFlash::new(&SMALL);
        flash.seed(seed);
        for at in 0..flash.bytes.len() {
            flash.bytes[at] = match (density, (flash.random() >> 56) as u8) {
                (0, any) => any,
                (1, any) => any | (flash.random() >> 56) as u8,
                (2, any) if any < 16 => any,
                (3, any) => any & 1,
                _ => 0xFF,
            };
        }
        go_on(&mut flash, |_| false);
    }

    #[test]
    fn damaged_items_are_not_there(
        edits in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>(), 1_usize..40), 1..12),
    ) {
        let (mut flash, written) = used();
        for (at, to, len) in edits {
            let at = at.index(flash.bytes.len());
            for (byte, index) in flash.bytes[at..].iter_mut().zip(0..len) {
                *byte = byte.wrapping_add(to).rotate_left(index as u32);
            }
        }
        go_on(&mut flash, |item| written.iter().any(|known| known == item));
    }

    /// Writes records with correct heads and seals, but with payloads that no code writes.
    #[test]
    fn signed_nonsense_is_not_there(
        records in prop::collection::vec(
            (0_u8..6, any::<u16>(), prop::collection::vec(any::<u8>(), 0..200), any::<bool>(), 0_u32..9),
            1..9,
        ),
    ) {
        let mut flash = MockFlash::new(&SMALL);
        let mut log = b"SNWL\x01\0\0\0\x05\0\0\0".to_vec();
        log.extend(crc(&log).to_le_bytes());
        for (kind, schema, payload, is_sealed, more) in records {
            // Some records do not end at the address that their head gives.
            let len = if more == 8 { u32::MAX - 3 } else { payload.len() as u32 + more / 4 };
            let mut head = vec![b'S', b'R', 1, kind];
            head.extend(schema.to_le_bytes().into_iter().chain([0, 0]).chain(len.to_le_bytes()));
            head.extend(crc(&head).to_le_bytes());
            let sealed: Vec<u8> = head.iter().chain(&payload).copied().collect();
            log.extend(&sealed);
            log.resize(log.len().next_multiple_of(4), 0xFF);
            log.extend(if is_sealed { crc(&sealed).to_le_bytes() } else { [0xFF; 4] });
        }
        flash.bytes[0x1000..][..log.len()].copy_from_slice(&log);
        let slot = log.len().min(0x800 + 16) - 16;
        flash.bytes[0x4000..][..slot].copy_from_slice(&log[16..][..slot]);
        go_on(&mut flash, |_| false);
    }
}
