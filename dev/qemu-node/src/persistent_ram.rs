//! Memory that survives a reset: flash, which is RAM here, and the record of a panic.
//!
//! This memory is in the machine's PSRAM. At a reset QEMU loads its image again, but the image has no part in this
//! memory. At power-on the memory is zero.

use core::ptr;

use sinew_qemu_node::limits::FLASH_LEN;

/// Address of the PSRAM of `mps2-an386`.
const AT: usize = 0x2100_0000;
/// Value that is stored after a panic.
const PANIC: u32 = 0x50A1_1C5A;

/// Content of the persistent memory.
#[repr(C)]
pub(crate) struct PersistentRam {
    panic: u32,
    pub(crate) flash: [u8; FLASH_LEN],
}

fn place() -> *mut PersistentRam {
    ptr::with_exposed_provenance_mut(AT)
}

impl PersistentRam {
    /// Returns the only reference to this memory. May be called once, at the start.
    #[expect(unsafe_code, reason = "it has an address, and no name that a linker knows")]
    pub(crate) fn take() -> &'static mut Self {
        // SAFETY: there are 16 MB of RAM, which no image uses; any bytes are valid numbers. Only `main` calls this
        // function.
        unsafe { &mut *place() }
    }

    /// Returns whether the previous run ended with a panic, and clears the record.
    pub(crate) fn take_panic(&mut self) -> bool {
        core::mem::take(&mut self.panic) == PANIC
    }

    /// Records that a panic ends this run.
    #[expect(unsafe_code, reason = "it has an address, and no name that a linker knows")]
    pub(crate) fn note_panic() {
        // SAFETY: as for `take`; code with a reference does not run any more. The write is volatile, since a reset
        // follows.
        unsafe { (&raw mut (*place()).panic).write_volatile(PANIC) }
    }
}
