//! Shared helpers of several tests.
#![expect(clippy::cast_possible_truncation, reason = "a small flash has small numbers")]

pub(crate) mod flash;

use flash::{MockFlash, PowerFailed};
use sinew_storage::{
    Approver, Area, BoardTable, Capacity, Descriptor, Disarmed, Error, Fault, Hash, Kind, Store,
    Stored,
};

pub(crate) type Result<T> = core::result::Result<T, Error<PowerFailed>>;

/// A small board: a few changes fill a sector of the log, and slots have two sectors each.
pub(crate) const SMALL: BoardTable = BoardTable {
    log: Area { start: 0x1000, sector_len: 0x1000, sectors: 3 },
    slots: &[
        Area { start: 0x4000, sector_len: 0x400, sectors: 2 },
        Area { start: 0x5000, sector_len: 0x400, sectors: 2 },
    ],
    capacity: Capacity { bodies: 4, dofs: 4, servos: 3 },
};

pub(crate) fn approver() -> Approver {
    Approver::new("Ada, stage manager").unwrap()
}

pub(crate) fn describe(kind: Kind, content: &[u8]) -> Descriptor {
    Descriptor::of(kind, 1, content, 0x1234_abcd, approver())
}

/// Returns meaningless bytes that depend only on a number.
pub(crate) fn content(number: u32, len: usize) -> Vec<u8> {
    let mut state = number;
    (0..len)
        .map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            // Some bytes are FF, like bytes that were never written.
            if state >> 28 == 0 { 0xFF } else { (state >> 24) as u8 }
        })
        .collect()
}

/// Returns bytes that start like a rig with a number of servos.
pub(crate) fn rig(number: u32, servos: u16, len: usize) -> Vec<u8> {
    let counts = [servos + 1, servos, 0, servos, servos];
    let mut bytes = b"SNWR\x01\x00".to_vec();
    bytes.extend(counts.into_iter().flat_map(u16::to_le_bytes));
    bytes.extend(content(number, len - bytes.len()));
    bytes
}

pub(crate) fn fault(number: u16) -> Fault {
    let time_us = u64::from(number) * 1000;
    Fault { run: 0, time_us, number, part: Some(3), state: 5, times: 2 }
}

/// The whole content of a store.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Everything {
    pub(crate) settings: Option<Vec<u8>>,
    pub(crate) rig: Option<Vec<u8>>,
    pub(crate) shows: Vec<Option<Vec<u8>>>,
    pub(crate) first_fault: Option<u16>,
    pub(crate) last_faults: Vec<u16>,
}

pub(crate) fn everything(store: &mut Store<&mut MockFlash>) -> Everything {
    let settings = store.settings().unwrap();
    let rig = store.rig().unwrap();
    let slots = 0..store.board().slots.len();
    let shows: Vec<_> = slots.map(|slot| store.show(slot).unwrap()).collect();
    let faults = store.faults().unwrap();
    Everything {
        settings: settings.map(|item| read(store, &item)),
        rig: rig.map(|item| read(store, &item)),
        shows: shows.into_iter().map(|item| item.map(|item| read(store, &item))).collect(),
        first_fault: faults.first.map(|fault| fault.number),
        last_faults: faults.last.iter().map(|fault| fault.number).collect(),
    }
}

/// Returns the content of an item, which must match its descriptor.
pub(crate) fn read(store: &mut Store<&mut MockFlash>, item: &Stored) -> Vec<u8> {
    let mut content = vec![0; item.descriptor().len as usize];
    store.read(item, 0, &mut content).unwrap();
    assert_eq!(Hash::of(&content), item.descriptor().hash);
    content
}

pub(crate) fn put(
    store: &mut Store<&mut MockFlash>,
    disarmed: &Disarmed,
    kind: Kind,
    content: &[u8],
) -> Result<Stored> {
    store.put(disarmed, &describe(kind, content), content)
}

/// Uploads an item like a host: in blocks, from the offset that the board returns.
pub(crate) fn upload(
    store: &mut Store<&mut MockFlash>,
    disarmed: &Disarmed,
    kind: Kind,
    content: &[u8],
    block: usize,
) -> Result<Stored> {
    let descriptor = describe(kind, content);
    let mut upload = store.begin(disarmed, &descriptor)?;
    loop {
        let from = upload.received() as usize;
        if from == content.len() {
            return store.end(disarmed, &upload);
        }
        let to = content.len().min(from + block);
        match store.write(disarmed, &mut upload, from as u32, &content[from..to]) {
            Err(Error::Torn { .. }) => upload = store.begin(disarmed, &descriptor)?,
            result => result?,
        }
    }
}

/// Prints lines, and checks that `docs/storage.md` contains them unchanged.
pub(crate) fn is_on_page(lines: &[String]) {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/storage.md");
    let page = std::fs::read_to_string(path).unwrap();
    println!("{}", lines.join("\n"));
    for line in lines {
        assert!(page.lines().any(|known| known == line), "not on the page: {line}");
    }
}
