//! Flash that reads and writes 32 bytes at once, like an STM32H7's: the store respects its units.

use embedded_storage::nor_flash::{ErrorType, NorFlash, ReadNorFlash};
use sinew_storage::{Area, BoardTable, Condition, Disarmed, Error, Kind, Store};

use crate::common::flash::{MockFlash, PowerFailed};
use crate::common::{SMALL, content, describe, fault, rig};

/// Larger sectors for the log: every fault takes 96 bytes in this flash.
const BOARD: BoardTable =
    BoardTable { log: Area { start: 0x1000, sector_len: 0x1800, sectors: 2 }, ..SMALL };

struct Coarse(MockFlash);

impl ErrorType for Coarse {
    type Error = PowerFailed;
}

impl ReadNorFlash for Coarse {
    const READ_SIZE: usize = 32;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        assert!(offset.is_multiple_of(32) && bytes.len().is_multiple_of(32));
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for Coarse {
    const WRITE_SIZE: usize = 32;
    const ERASE_SIZE: usize = 1024;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerFailed> {
        self.0.erase(from, to)
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        assert!(offset.is_multiple_of(32) && bytes.len().is_multiple_of(32));
        let whole = self.0.bytes[offset as usize..][..bytes.len()].iter().all(|byte| *byte == 0xFF);
        assert!(whole, "a unit at {offset:#x} is written twice");
        self.0.write(offset, bytes)
    }
}

fn upload(store: &mut Store<Coarse>, disarmed: &Disarmed, kind: Kind, content: &[u8]) {
    let mut upload = store.begin(disarmed, &describe(kind, content)).unwrap();
    let mut from = 0;
    for block in content.chunks(96) {
        store.write(disarmed, &mut upload, from, block).unwrap();
        from += 96;
    }
    let item = store.end(disarmed, &upload).unwrap();
    let mut found = vec![0; content.len()];
    store.read(&item, 0, &mut found).unwrap();
    assert_eq!(found, content);
}

#[test]
fn everything_goes_by_units_of_32_bytes() {
    let (mut store, disarmed) = Store::open(Coarse(MockFlash::new(&BOARD)), BOARD).unwrap();
    store.tidy(&disarmed).unwrap();
    for number in 0..40 {
        upload(&mut store, &disarmed, Kind::Settings, &content(number, 75));
        upload(&mut store, &disarmed, Kind::Rig, &rig(number, 3, 201));
        upload(&mut store, &disarmed, Kind::Show, &content(number, 999));
        store.delete_show(&disarmed, 0).unwrap();
        store.tidy(&disarmed).unwrap();
        store.record_fault(&fault(7)).unwrap();
    }
    let other = content(1, 300);
    let mut begun = store.begin(&disarmed, &describe(Kind::Show, &other)).unwrap();
    let odd = store.write(&disarmed, &mut begun, 0, &other[..100]);
    assert_eq!(odd, Err(Error::Alignment { granule: 32, offset: 0, len: 100 }));
    let (mut store, _) = Store::open(store.close(), BOARD).unwrap();
    assert_eq!(store.condition(), Condition::Good);
    assert_eq!(
        store.settings().unwrap().unwrap().descriptor(),
        &describe(Kind::Settings, &content(39, 75))
    );
    assert_eq!(store.faults().unwrap().last.len(), 16);
}
