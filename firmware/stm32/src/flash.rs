//! The chip's flash, as a driver for storage.

use embassy_stm32::flash::{Blocking, Error, Flash};
use embassy_stm32::pac;
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash,
};

use crate::watchdog;

/// Address of the flash in memory.
const BASE: u32 = 0x0800_0000;
/// Size of the flash, bytes.
pub(crate) const LEN: usize = 0x8_0000;

/// The chip's flash. Offsets count from its beginning.
pub struct Chip(Flash<'static, Blocking>);

/// An error of the flash's driver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChipError(Error);

impl Chip {
    /// Creates the flash from embassy's driver.
    pub fn new(flash: Flash<'static, Blocking>) -> Self {
        Self(flash)
    }
}

/// Returns a range of the flash as memory, or `None` if the range is not in the flash. The slice is valid as long as
/// nobody writes or erases there.
pub(crate) fn memory(range: core::ops::Range<u32>) -> Option<&'static [u8]> {
    let len = range.end.checked_sub(range.start)? as usize;
    if range.end as usize > LEN {
        return None;
    }
    let at = (BASE + range.start) as *const u8;
    // SAFETY: the range is in flash. The node guarantees that readers are done before somebody writes there.
    Some(unsafe { core::slice::from_raw_parts(at, len) })
}

impl NorFlashError for ChipError {
    fn kind(&self) -> NorFlashErrorKind {
        match self.0 {
            Error::Size => NorFlashErrorKind::OutOfBounds,
            Error::Unaligned => NorFlashErrorKind::NotAligned,
            _ => NorFlashErrorKind::Other,
        }
    }
}

impl ErrorType for Chip {
    type Error = ChipError;
}

impl ReadNorFlash for Chip {
    const READ_SIZE: usize = 1;
    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), ChipError> {
        self.0.blocking_read(offset, bytes).map_err(ChipError)
    }
    fn capacity(&self) -> usize {
        LEN
    }
}

#[cfg(feature = "stm32f446re")]
const UNITS: (usize, usize) = (4, 0x4000);
#[cfg(feature = "stm32g474re")]
const UNITS: (usize, usize) = (8, 0x800);

impl NorFlash for Chip {
    const WRITE_SIZE: usize = UNITS.0;
    /// Size of the smallest sector, bytes.
    const ERASE_SIZE: usize = UNITS.1;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), ChipError> {
        watchdog::wait_for_long();
        erase_by_words();
        let erased = self.0.blocking_erase(from, to).map_err(ChipError);
        forget_cached();
        erased
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), ChipError> {
        let written = self.0.blocking_write(offset, bytes).map_err(ChipError);
        forget_cached();
        written
    }
}

/// Makes an erase work on 32 bits at a time. embassy-stm32 0.6.0 erases at the parallelism that it finds: after a
/// reset and after each write that is 8 bits, and 128 kB then take up to 4 s instead of 2 s. The setting needs an
/// unlocked register, and embassy continues with the register unlocked.
#[cfg(feature = "stm32f446re")]
fn erase_by_words() {
    if pac::FLASH.cr().read().lock() {
        pac::FLASH.keyr().write_value(0x4567_0123);
        pac::FLASH.keyr().write_value(0xCDEF_89AB);
    }
    pac::FLASH.cr().modify(|w| w.set_psize(pac::flash::vals::Psize::PSIZE32));
}

#[cfg(feature = "stm32g474re")]
fn erase_by_words() {}

/// Empties the data cache: it may contain bytes that were read before a write, and a write does not update it.
fn forget_cached() {
    if pac::FLASH.acr().read().dcen() {
        pac::FLASH.acr().modify(|w| w.set_dcen(false));
        pac::FLASH.acr().modify(|w| w.set_dcrst(true));
        pac::FLASH.acr().modify(|w| w.set_dcrst(false));
        pac::FLASH.acr().modify(|w| w.set_dcen(true));
    }
}
