//! The square root of an `f32`, in a single instruction if the target has one, with the same bits on all targets.
//!
//! `f32::sqrt` is not in `core`. `libm` computes it with integers: about 50 instructions on Arm, whereas the
//! Cortex-M4F has one instruction. Both round correctly, as IEEE 754 requires for square roots, so the bits are
//! equal. This is a separate crate, so that the motion core can forbid `unsafe`.

#![no_std]

/// Returns the square root, correctly rounded; NaN below zero.
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
        // SAFETY: changes one core register, the named FPU register, which hard-float targets have, and flags of
        // FPSCR, which need not be preserved.
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
