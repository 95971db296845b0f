//! The numbers of `docs/storage.md`: each of its tables is made here, and must stand there as it is.
#![expect(clippy::cast_possible_truncation, reason = "the F446 has small numbers")]

use sinew_rig::board::BoardRig;
use sinew_storage::{Area, BoardTable, Capacity, Kind, Store};

use crate::common::flash::MockFlash;
use crate::common::{content, fault, is_on_page, put, rig};

const F446: BoardTable = BoardTable::NUCLEO_F446RE;
/// What the settings of a controller may take.
const SETTINGS_LEN: u32 = 512;

/// Bytes of ten minutes, as `docs/show-format.md` has them.
fn ten_minutes(motion: &str) -> f32 {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/show-format.md");
    let page = std::fs::read_to_string(path).unwrap();
    let start = format!("| {motion} | 0.25° | ");
    let line = page.lines().find_map(|line| line.strip_prefix(&start)).unwrap();
    line.split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn minutes_of_show() {
    let slots = [
        ("a slot of the NUCLEO-F446RE, 128 kB", F446.slots[0]),
        ("an SPI flash of 4 MB", Area { start: 0, sector_len: 4096, sectors: 1024 }),
        ("an SPI flash of 16 MB", Area { start: 0, sector_len: 4096, sectors: 4096 }),
    ];
    let lines = slots.map(|(name, area)| {
        let minutes = |motion| {
            let bytes_per_second = ten_minutes(motion) / 600.0;
            area.minutes::<MockFlash>(bytes_per_second).unwrap()
        };
        let holds = area.holds::<MockFlash>();
        format!("| {name} | {holds} | {:.1} | {:.1} |", minutes("fight"), minutes("walk"))
    });
    is_on_page(&lines);
    assert_eq!(F446.slots[0].minutes::<MockFlash>(0.0), None);
    assert_eq!(F446.slots[0].minutes::<MockFlash>(f32::NAN), None);
}

#[test]
fn rigs_that_fit() {
    let largest = F446.largest_rig::<MockFlash>(SETTINGS_LEN);
    let mut lines: Vec<String> = [6, 20, 32]
        .into_iter()
        .map(|joints| {
            let description = sinew_rig::new::arm(joints).unwrap();
            let mechanism = description.mechanism().unwrap();
            let rig = BoardRig::<64, 64, 64>::bake(&description, &mechanism).unwrap();
            let mut bytes = vec![0; 0x1_0000];
            let len = rig.encode(&mut bytes).unwrap();
            F446.capacity.check(bytes.first_chunk().unwrap()).unwrap();
            assert!(len <= largest as usize);
            format!("| an arm of {joints} joints and servos | {len} |")
        })
        .collect();
    lines.push(format!("| the most, beside {SETTINGS_LEN} bytes of settings | {largest} |"));
    is_on_page(&lines);
    let Capacity { bodies, dofs, servos } = F446.capacity;
    is_on_page(&[format!(
        "The NUCLEO-F446RE takes {bodies} bodies, {dofs} degrees of freedom and {servos} servos."
    )]);
}

/// Sectors last 10,000 erases at least (DS10693, the STM32F446RE datasheet, "Flash memory endurance").
const ENDURANCE: u64 = 10_000;

#[test]
fn wear() {
    let mut lines = Vec::new();
    for len in [128, SETTINGS_LEN, 2048] {
        lines.push(worn(
            &format!("a change of {len} bytes of settings"),
            2000,
            |store, disarmed, number| {
                put(store, disarmed, Kind::Settings, &content(number, len as usize)).unwrap();
            },
        ));
    }
    lines.push(worn("a fault", 4000, |store, disarmed, number| {
        store.tidy(disarmed).unwrap();
        store.record_fault(&fault(number as u16)).unwrap();
    }));
    lines.push(worn("an upload of a rig of 32 servos", 200, |store, disarmed, number| {
        put(store, disarmed, Kind::Rig, &rig(number, 32, 6468)).unwrap();
    }));
    is_on_page(&lines);
}

fn worn(
    name: &str,
    count: u32,
    mut operation: impl FnMut(&mut Store<&mut MockFlash>, &sinew_storage::Disarmed, u32),
) -> String {
    let mut flash = MockFlash::new(&F446);
    let (mut store, disarmed) = Store::open(&mut flash, F446).unwrap();
    put(&mut store, &disarmed, Kind::Settings, &content(0, SETTINGS_LEN as usize)).unwrap();
    put(&mut store, &disarmed, Kind::Rig, &rig(0, 20, 4000)).unwrap();
    for number in 1..=count {
        operation(&mut store, &disarmed, number);
    }
    let log = flash.erases.iter().filter(|(start, _)| (0x4000..0x1_0000).contains(start));
    let erases: Vec<u32> = log.map(|(_, erases)| *erases).collect();
    let (least, most) = (erases.iter().min().unwrap(), erases.iter().max().unwrap());
    assert!(most - least <= 1, "the wear is uneven: {erases:?}");
    let sum: u32 = erases.iter().sum();
    let until = u64::from(count) * ENDURANCE / u64::from(*most);
    format!("| {name} | {count} | {sum} | {} | {} |", thousands(until / 1000), erases.len())
}

/// A number of thousands, as people read it.
fn thousands(number: u64) -> String {
    match (number / 1000, number % 1000) {
        (0, rest) => format!("{rest},000"),
        (millions, rest) => format!("{millions},{rest:03},000"),
    }
}
