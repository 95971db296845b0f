//! Measures the depth of the stack by painting it.

/// A pattern that is unlikely to be on the stack by chance.
const PAINT: u32 = 0xa5c3_3c5a;

/// Number of bytes that are painted below the caller's frame.
const PAINTED_BYTES: usize = 64 * 1024;

/// Returns the largest number of bytes that `run` and its callees have on the stack, below the caller's frame.
#[inline(never)]
#[expect(unsafe_code, reason = "the stack below the stack pointer is no variable of anyone")]
pub(super) fn high_water_bytes(mut run: impl FnMut()) -> usize {
    let top = cortex_m::register::msp::read() as usize;
    let words = || (top - PAINTED_BYTES..top).step_by(size_of::<u32>());
    for address in words() {
        // SAFETY: RAM below the stack pointer, of which this board has megabytes, and no interrupt uses it.
        unsafe { core::ptr::with_exposed_provenance_mut::<u32>(address).write_volatile(PAINT) };
    }
    run();
    let untouched = words()
        // SAFETY: as above.
        .take_while(|address| unsafe {
            core::ptr::with_exposed_provenance::<u32>(*address).read_volatile() == PAINT
        })
        .count();
    PAINTED_BYTES - untouched * size_of::<u32>()
}
