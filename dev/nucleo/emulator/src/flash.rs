//! The F446's flash array, which rigless leaves out: what is programmed stays, what is erased is all ones, and the core
//! stands still meanwhile.
//!
//! The array is RAM that the core finds where flash is. So programming is a plain store, and takes no time.

use rigless::emulator::{Host, Memory};
use rigless::soc::Width;

/// Where the core finds it.
pub const BASE: u64 = 0x0800_0000;
/// Where nothing is on this part: the runtime's own door to it.
pub const ARRAY: u64 = 0x9000_0000;
/// Bytes of the F446RE.
pub const LEN: usize = 512 << 10;
/// `FLASH_CR`.
pub const CR: u64 = 0x4002_3C10;

const SER: u64 = 1 << 1;
const STRT: u64 = 1 << 16;
const BSY: u64 = 1 << 16;

/// Of each sector of 16, 64 and 128 kB: its bytes.
const SECTORS: [usize; 8] =
    [16 << 10, 16 << 10, 16 << 10, 16 << 10, 64 << 10, 128 << 10, 128 << 10, 128 << 10];

/// An erase that is under way.
#[derive(Debug, Default)]
pub struct Eraser {
    sector: Option<usize>,
}

impl Eraser {
    /// The firmware writes `FLASH_CR`. Which sector it erases, if it does.
    ///
    /// The first half is erased at once, the other at its end: a reset between them leaves neither what was there, nor
    /// an empty sector.
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

    /// Ends it when `FLASH_SR` says that it is over. Which sector it was.
    pub fn end(&mut self, sr: u64, host: &mut dyn Host) -> Option<usize> {
        if sr & BSY != 0 {
            return None;
        }
        let sector = self.sector.take()?;
        let (from, len) = place(sector);
        clear(host, from + len as u64 / 2, len / 2);
        Some(sector)
    }

    /// A reset: what was not erased stays.
    pub fn cut(&mut self) {
        self.sector = None;
    }

    /// Whether one is under way: the core stands still.
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

/// Puts bytes into the array, whole words.
pub fn fill(host: &mut dyn Host, from: u64, bytes: &[u8]) {
    let (words, _) = bytes.as_chunks::<8>();
    for (address, word) in (ARRAY + from..).step_by(8).zip(words) {
        host.write(address, Width::W64, u64::from_le_bytes(*word)).expect("the array is RAM");
    }
}

/// All that the array holds.
pub fn read(memory: &mut dyn Host) -> Vec<u8> {
    let words = (ARRAY..ARRAY + LEN as u64).step_by(8);
    let word = |address| Memory::read(memory, address, Width::W64).expect("the array is RAM");
    words.map(word).flat_map(u64::to_le_bytes).collect()
}
