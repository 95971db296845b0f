//! The reason for our own log: a test of an alternative library, on the same flash, with the same power cuts.
//!
//! If this test fails, the library has improved, and it may be time to evaluate it again.

use core::pin::pin;
use core::task::{Context, Poll, Waker};

use embedded_storage::nor_flash::{ErrorType, NorFlash as _, ReadNorFlash as _};
use embedded_storage_async::nor_flash::{NorFlash, ReadNorFlash};
use sequential_storage::cache::Cache;
use sequential_storage::map::{MapConfig, MapStorage};

use crate::common::flash::{MockFlash, PowerFailed};
use crate::common::{SMALL, content, is_on_page};

/// The flash with the traits of the library.
struct Async<'a>(&'a mut MockFlash);

impl ErrorType for Async<'_> {
    type Error = PowerFailed;
}

impl ReadNorFlash for Async<'_> {
    const READ_SIZE: usize = 1;

    async fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), PowerFailed> {
        self.0.read(offset, bytes)
    }

    fn capacity(&self) -> usize {
        self.0.capacity()
    }
}

impl NorFlash for Async<'_> {
    const WRITE_SIZE: usize = 4;
    const ERASE_SIZE: usize = 0x1000;

    async fn erase(&mut self, from: u32, to: u32) -> Result<(), PowerFailed> {
        self.0.erase(from, to)
    }

    async fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), PowerFailed> {
        self.0.write(offset, bytes)
    }
}

fn now<T>(future: impl Future<Output = T>) -> T {
    match pin!(future).poll(&mut Context::from_waker(Waker::noop())) {
        Poll::Ready(result) => result,
        Poll::Pending => unreachable!("the flash never waits"),
    }
}

fn map(
    flash: &mut MockFlash,
) -> MapStorage<u8, Async<'_>, impl sequential_storage::cache::CacheImpl<u8>> {
    MapStorage::new(Async(flash), MapConfig::new(0x1000..0x4000), Cache::new_uncached())
}

fn store(flash: &mut MockFlash, key: u8, value: &[u8]) -> bool {
    now(map(flash).store_item(&mut [0; 2048], &key, &value)).is_ok()
}

/// Returns a value, if there is one and the library can read it.
fn fetch(flash: &mut MockFlash, key: u8) -> Option<Vec<u8>> {
    let mut buffer = [0; 2048];
    let value = now(map(flash).fetch_item::<&[u8]>(&mut buffer, &key));
    value.ok().flatten().map(<[u8]>::to_vec)
}

#[test]
fn it_loses_items_where_a_cut_erase_leaves_what_the_trait_allows() {
    let rig = content(1, 300);
    let mut start = MockFlash::new(&SMALL);
    start.may_write_twice = true;
    assert!(store(&mut start, 2, &rig));
    let (mut cuts, mut neither, mut lost, mut read_erases, mut twice) = (0, 0, 0, 0, 0);
    for change in 0..120 {
        let mut whole = start.clone();
        whole.steps = 0;
        assert!(store(&mut whole, 1, &content(change, 90)));
        let erases = whole.erases != start.erases;
        for (seed, step) in (0..if erases { 20 } else { 1 })
            .flat_map(|seed| (0..whole.steps).map(move |step| (seed, step)))
        {
            let mut flash = start.clone();
            flash.seed(u64::from(change * 100_000 + seed * 1000 + step));
            flash.power = Some(step);
            assert!(!store(&mut flash, 1, &content(change, 90)));
            flash.restart();
            cuts += 1;
            let before = flash.erases.clone();
            neither += u32::from(fetch(&mut flash, 2).as_ref() != Some(&rig));
            read_erases += u32::from(flash.erases != before);
            // The next change finds the remains of the power cut.
            store(&mut flash, 1, &content(change, 90));
            twice += u32::from(flash.twice > 0);
            lost += u32::from(fetch(&mut flash, 2).as_ref() != Some(&rig));
        }
        start = whole;
    }
    println!("{cuts} cuts: the rig not found after {neither}, a word written twice after {twice}");
    is_on_page(&[format!(
        "  In {cuts} cuts of a change of settings the rig was lost for good {lost} times, and a read erased a sector \
         {read_erases} times."
    )]);
    assert!(lost > 0 && read_erases > 0);
}
