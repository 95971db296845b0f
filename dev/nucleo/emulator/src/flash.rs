//! The flash array of the F446, which rigless does not model: programmed data stays, erased data is all ones, and the
//! core stops during an erase.
//!
//! The array is RAM at the address of flash. Programming is therefore a plain store, and takes no time.

use rigless::emulator::{Host, Memory};
use rigless::soc::Width;

/// Address of the array for the core.
pub const BASE: u64 = 0x0800_0000;
/// An address that is unused on this part: the emulator accesses the array there.
pub const ARRAY: u64 = 0x9000_0000;
/// Size of the F446RE's flash, bytes.
pub const LEN: usize = 512 << 10;
/// Address of `FLASH_CR`.
pub const CR: u64 = 0x4002_3C10;

const SER: u64 = 1 << 1;
const STRT: u64 = 1 << 16;
const BSY: u64 = 1 << 16;

/// Size of each sector, bytes.
const SECTORS: [usize; 8] =
    [16 << 10, 16 << 10, 16 << 10, 16 << 10, 64 << 10, 128 << 10, 128 << 10, 128 << 10];

/// An erase in progress.
#[derive(Debug, Default)]
pub struct Eraser {
    sector: Option<usize>,
}

impl Eraser {
    /// Handles a write of `FLASH_CR`. Returns the sector, if the write starts an erase.
    ///
    /// The first half of the sector is erased at once, the second half at the end. A reset in between leaves neither
    /// the old content nor an empty sector.
    pub fn begin(&mut self, cr: u64, host: &mut dyn Host) -> Option<usize> {
        let sector = usize::try_from(cr >> 3 & 15).ok()?;
        if cr & SER == 0 || cr & STRT == 0 || sector >= SECTORS.len() || self.sector.is_some() {
            return None;
        }
        self.sector = Some(sector);
        let (from, len) = place(sector);
        clear(host, from, len / 2);
        Some(sector)
    }

    /// Ends the erase when `FLASH_SR` reports its end. Returns the erased sector, or `None` if no erase has ended.
    pub fn end(&mut self, sr: u64, host: &mut dyn Host) -> Option<usize> {
        if sr & BSY != 0 {
            return None;
        }
        let sector = self.sector.take()?;
        let (from, len) = place(sector);
        clear(host, from + len as u64 / 2, len / 2);
        Some(sector)
    }

    /// Cancels the erase at a reset: the rest of the sector stays.
    pub fn cut(&mut self) {
        self.sector = None;
    }

    /// Returns whether an erase is in progress; the core stands still until it ends.
    pub fn is_busy(&self) -> bool {
        self.sector.is_some()
    }
}

fn place(sector: usize) -> (u64, usize) {
    (SECTORS[..sector].iter().map(|len| *len as u64).sum(), SECTORS[sector])
}

fn clear(host: &mut dyn Host, from: u64, len: usize) {
    fill(host, from, &vec![0xFF; len]);
}

/// Writes bytes into the array, whole words only.
pub fn fill(host: &mut dyn Host, from: u64, bytes: &[u8]) {
    let (words, _) = bytes.as_chunks::<8>();
    for (address, word) in (ARRAY + from..).step_by(8).zip(words) {
        host.write(address, Width::W64, u64::from_le_bytes(*word)).expect("the array is RAM");
    }
}

/// Returns the content of the array.
pub fn read(memory: &mut dyn Host) -> Vec<u8> {
    let words = (ARRAY..ARRAY + LEN as u64).step_by(8);
    let word = |address| Memory::read(memory, address, Width::W64).expect("the array is RAM");
    words.map(word).flat_map(u64::to_le_bytes).collect()
}
