//! Reasons for the chip's start, and the record that a panic has left in RAM.

use core::mem::MaybeUninit;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embassy_stm32::pac;
use sinew_firmware::node::causes;
use sinew_firmware::supervisor::FaultSet;

/// Source position of a panic. It is kept in RAM, which survives a reset.
#[repr(C)]
#[derive(Clone, Copy)]
struct Record {
    magic: u32,
    line: u32,
    /// End of the file's name.
    file: [u8; 48],
    crc: u32,
}

const MAGIC: u32 = 0x5357_5031;

// SAFETY: nothing initializes it at a start; it is used only if magic and CRC are right.
#[unsafe(link_section = ".uninit.panic")]
static mut KEPT: MaybeUninit<Record> = MaybeUninit::uninit();

impl Record {
    fn own_crc(&self) -> u32 {
        // Without a table: a table of 1 kB would be on the stack, where a panic may have little space left.
        let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        digest.update(&self.magic.to_le_bytes());
        digest.update(&self.line.to_le_bytes());
        digest.update(&self.file);
        digest.finalize()
    }
}

/// Stores the position of a panic for the next start.
pub(crate) fn record(file: &str, line: u32) {
    let mut record = Record { magic: MAGIC, line, file: [0; 48], crc: 0 };
    for (to, from) in record.file.iter_mut().rev().zip(file.bytes().rev()) {
        *to = from;
    }
    record.crc = record.own_crc();
    // SAFETY: interrupts are off, and the next start reads it before they are enabled.
    unsafe { (&raw mut KEPT).write_volatile(MaybeUninit::new(record)) };
}

/// Returns the reasons for the chip's start, as faults. Clears their flags and record, so that the next start reports
/// only its own reasons.
pub(crate) fn why() -> FaultSet {
    // SAFETY: every bit pattern is a valid `Record`; interrupts are off.
    let record = unsafe { (&raw const KEPT).read_volatile().assume_init() };
    let is_panic = record.magic == MAGIC && record.crc == record.own_crc();
    // SAFETY: interrupts are off.
    unsafe { (&raw mut KEPT).write_volatile(MaybeUninit::zeroed()) };
    let flags = pac::RCC.csr().read();
    pac::RCC.csr().modify(|w| w.set_rmvf(true));
    causes(was_watchdog(flags), was_brown_out(flags), is_panic)
}

#[cfg(feature = "stm32f446re")]
fn was_watchdog(flags: pac::rcc::regs::Csr) -> bool {
    flags.wdgrstf()
}

#[cfg(feature = "stm32g474re")]
fn was_watchdog(flags: pac::rcc::regs::Csr) -> bool {
    flags.iwdgrstf()
}

/// Returns whether a brown-out happened without power-on, which sets the brown-out's flag, too.
#[cfg(feature = "stm32f446re")]
fn was_brown_out(flags: pac::rcc::regs::Csr) -> bool {
    flags.borrstf() && !flags.porrstf()
}

/// Returns false: on this chip, power-on sets the same flag as a brown-out, so they cannot be distinguished.
#[cfg(feature = "stm32g474re")]
fn was_brown_out(_: pac::rcc::regs::Csr) -> bool {
    false
}
