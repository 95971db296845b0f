//! The square root of an `f32` in one instruction where the target has one, with the same bits everywhere.
//!
//! `f32::sqrt` is not in `core`. `libm` computes it in integers: some 50 instructions on Arm, where the Cortex-M4F has
//! one. Both round correctly, as IEEE 754 asks of a square root, so the bits are the same. It is a crate of its own, so
//! that the motion core can forbid `unsafe`.

#![no_std]

/// The square root, correctly rounded; NaN below zero.
///
/// ```
/// assert_eq!(sinew_fpu::sqrt(2.25), 1.5);
/// assert!(sinew_fpu::sqrt(-1.0).is_nan());
/// ```
#[inline]
pub fn sqrt(x: f32) -> f32 {
    // The hard-float ABI implies an FPU. Stable Rust cannot name the FPU's registers as operands on these targets, so
    // the number passes through a core register.
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let mut bits = x.to_bits();
        #[expect(unsafe_code, reason = "stable Rust has no safe function for the instruction")]
        // SAFETY: changes one register of the core, the named one of the FPU, which targets of the hard-float ABI
        // have, and flags of FPSCR, which are not said to be preserved.
        unsafe {
            core::arch::asm!(
                "vmov s0, {bits}",
                "vsqrt.f32 s0, s0",
                "vmov {bits}, s0",
                bits = inout(reg) bits,
                out("s0") _,
                options(pure, nomem, nostack)
            );
        }
        f32::from_bits(bits)
    }
    #[cfg(not(all(target_arch = "arm", target_abi = "eabihf")))]
    libm::sqrtf(x)
}
