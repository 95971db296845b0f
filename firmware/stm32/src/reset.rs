//! Why the chip starts, and what a panic has left in RAM.

use core::mem::MaybeUninit;

use crc::{CRC_32_ISO_HDLC, Crc, NoTable};
use embassy_stm32::pac;
use sinew_firmware::node::causes;
use sinew_firmware::supervisor::FaultSet;

/// Where somebody has panicked: a reset keeps RAM.
#[repr(C)]
#[derive(Clone, Copy)]
struct Record {
    magic: u32,
    line: u32,
    /// How its file ends.
    file: [u8; 48],
    crc: u32,
}

const MAGIC: u32 = 0x5357_5031;

// SAFETY: nothing is put there at a start; what is read has its magic and its CRC.
#[unsafe(link_section = ".uninit.panic")]
static mut KEPT: MaybeUninit<Record> = MaybeUninit::uninit();

impl Record {
    fn own_crc(&self) -> u32 {
        // A table of 1 kB would be made on the stack, where a panic may have little of it.
        let crc = Crc::<u32, NoTable>::new(&CRC_32_ISO_HDLC);
        let mut digest = crc.digest();
        digest.update(&self.magic.to_le_bytes());
        digest.update(&self.line.to_le_bytes());
        digest.update(&self.file);
        digest.finalize()
    }
}

/// Keeps where a panic was, for the next start.
pub(crate) fn record(file: &str, line: u32) {
    let mut record = Record { magic: MAGIC, line, file: [0; 48], crc: 0 };
    for (to, from) in record.file.iter_mut().rev().zip(file.bytes().rev()) {
        *to = from;
    }
    record.crc = record.own_crc();
    // SAFETY: interrupts are off, and the start reads it before they are on.
    unsafe { (&raw mut KEPT).write_volatile(MaybeUninit::new(record)) };
}

/// Why the chip starts, as faults. What told it is cleared: the next start has its own reasons.
pub(crate) fn why() -> FaultSet {
    // SAFETY: all bits of it are numbers; interrupts are off.
    let record = unsafe { (&raw const KEPT).read_volatile().assume_init() };
    let is_panic = record.magic == MAGIC && record.crc == record.own_crc();
    // SAFETY: as above.
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

/// A brown-out alone: power-on sets its flag, too.
#[cfg(feature = "stm32f446re")]
fn was_brown_out(flags: pac::rcc::regs::Csr) -> bool {
    flags.borrstf() && !flags.porrstf()
}

/// The flag of a brown-out is that of power-on, too: this chip cannot tell them apart.
#[cfg(feature = "stm32g474re")]
fn was_brown_out(_: pac::rcc::regs::Csr) -> bool {
    false
}
