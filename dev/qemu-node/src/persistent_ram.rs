//! What a reset leaves as it is: flash, which is RAM here, and the record of a panic.
//!
//! They lie in the machine's PSRAM, into which QEMU loads nothing: what it loads, it loads again at a reset. At
//! power-on it is zero.

use core::ptr;

use sinew_qemu_node::limits::FLASH_LEN;

/// Where the PSRAM of `mps2-an386` begins.
const AT: usize = 0x2100_0000;
/// What stands there behind a panic.
const PANIC: u32 = 0x50A1_1C5A;

/// All of it.
#[repr(C)]
pub(crate) struct PersistentRam {
    panic: u32,
    pub(crate) flash: [u8; FLASH_LEN],
}

fn place() -> *mut PersistentRam {
    ptr::with_exposed_provenance_mut(AT)
}

impl PersistentRam {
    /// The one reference to it: to be taken once, at the start.
    #[expect(unsafe_code, reason = "it has an address, and no name that a linker knows")]
    pub(crate) fn take() -> &'static mut Self {
        // SAFETY: 16 MB of RAM are there, of which no image has a part; any bytes are numbers. `main` alone calls it.
        unsafe { &mut *place() }
    }

    /// Whether the run before ended by a panic.
    pub(crate) fn take_panic(&mut self) -> bool {
        core::mem::take(&mut self.panic) == PANIC
    }

    /// A panic ends this run.
    #[expect(unsafe_code, reason = "it has an address, and no name that a linker knows")]
    pub(crate) fn note_panic() {
        // SAFETY: as for `take`; what has a reference runs no more. A reset follows, so it is written before.
        unsafe { (&raw mut (*place()).panic).write_volatile(PANIC) }
    }
}
