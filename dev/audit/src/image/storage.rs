//! Storage in flash with arbitrary content and arbitrary errors, with the smallest and the largest granule.

use core::hint::black_box;

use embedded_storage::nor_flash::{ErrorType, NorFlash, NorFlashErrorKind, ReadNorFlash};
use sinew_storage::{
    Approver, Area, BoardTable, Capacity, Descriptor, Disarmed, Fault, Hash, Kind, Store,
};

use super::{slice, slice_mut};

/// Flash with a write granule of `GRANULE` bytes, and arbitrary content.
pub(crate) struct Flash<const GRANULE: usize>;

impl<const GRANULE: usize> ErrorType for Flash<GRANULE> {
    type Error = NorFlashErrorKind;
}

impl<const GRANULE: usize> ReadNorFlash for Flash<GRANULE> {
    const READ_SIZE: usize = 1;

    #[inline(never)]
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), Self::Error> {
        black_box((offset, bytes));
        black_box(Ok(()))
    }

    fn capacity(&self) -> usize {
        black_box(1)
    }
}

impl<const GRANULE: usize> NorFlash for Flash<GRANULE> {
    const WRITE_SIZE: usize = GRANULE;
    const ERASE_SIZE: usize = 64;

    #[inline(never)]
    fn erase(&mut self, from: u32, to: u32) -> Result<(), Self::Error> {
        black_box((from, to));
        black_box(Ok(()))
    }

    #[inline(never)]
    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), Self::Error> {
        black_box((offset, bytes));
        black_box(Ok(()))
    }
}

fn store<const GRANULE: usize>() -> Option<(Store<Flash<GRANULE>>, Disarmed)> {
    let board = BoardTable { slots: slice(), ..BoardTable::NUCLEO_F446RE };
    black_box(Store::open(Flash, black_box(board)).ok())
}

fn descriptor() -> Option<Descriptor> {
    let approver = Approver::new(black_box("")).ok()?;
    black_box(approver.name());
    let kind = black_box(Kind::Settings);
    Some(black_box(Descriptor::of(kind, black_box(1), slice(), black_box(1), approver)))
}

#[inline(never)]
pub(crate) fn tables() {
    let (board, area) = black_box((BoardTable::NUCLEO_F446RE, None::<Area>));
    if let Some(area) = area {
        black_box((area.total_len(), area.end(), area.holds::<Flash<1>>()));
        black_box(area.minutes::<Flash<1>>(black_box(1.0)));
    }
    black_box(board.largest_rig::<Flash<1>>(black_box(1)));
    black_box(&board.capacity.check(black_box(&[0; Capacity::HEAD_LEN])));
    black_box(&Hash::of(slice()));
    if let Some(descriptor) = descriptor() {
        black_box(descriptor.check_schema(black_box(1)).is_ok());
    }
}

#[inline(never)]
pub(crate) fn items() {
    items_of::<1>();
    items_of::<32>();
}

fn items_of<const GRANULE: usize>() {
    let Some((mut store, _)) = store::<GRANULE>() else { return };
    black_box((store.condition(), store.board(), store.run()));
    let stored = [store.settings(), store.rig(), store.show(black_box(1))];
    for item in stored.into_iter().flatten().flatten() {
        black_box((item.descriptor(), item.content(slice()), item.place()));
        black_box(store.read(&item, black_box(1), slice_mut()).is_ok());
    }
    black_box(&store.close());
}

#[inline(never)]
pub(crate) fn uploads() {
    uploads_of::<1>();
    uploads_of::<32>();
}

fn uploads_of<const GRANULE: usize>() {
    let (Some((mut store, disarmed)), Some(descriptor)) = (store::<GRANULE>(), descriptor()) else {
        return;
    };
    black_box(store.tidy(&disarmed).is_ok());
    if let Ok(mut upload) = store.begin(&disarmed, &descriptor) {
        black_box((upload.descriptor(), upload.received()));
        black_box(upload.place::<Flash<GRANULE>>());
        black_box(store.write(&disarmed, &mut upload, black_box(1), slice()).is_ok());
        black_box(&store.end(&disarmed, &upload));
    }
    black_box(&store.put(&disarmed, &descriptor, slice()));
    black_box(store.delete_show(&disarmed, black_box(1)).is_ok());
}

#[inline(never)]
pub(crate) fn faults() {
    faults_of::<1>();
    faults_of::<32>();
}

fn faults_of<const GRANULE: usize>() {
    let Some((mut store, _)) = store::<GRANULE>() else { return };
    let fault = Fault { run: 1, time_us: 1, number: 1, part: None, state: 1, times: 1 };
    black_box(store.record_fault(black_box(&fault)).is_ok());
    if let Ok(faults) = store.faults() {
        black_box((faults.first, faults.last.len()));
    }
    black_box(store.clear_faults().is_ok());
    black_box(store.is_damaged(black_box(Kind::Rig)).is_ok());
}
