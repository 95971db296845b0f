//! The square root, by the instruction that the target has for it.
//!
//! `f32::sqrt` is not in `core`, and `libm` computes it in integers on Arm, in some 50 instructions where the
//! Cortex-M4F has one. Both round correctly, as IEEE 754 asks of a square root, so the bits are the same. A crate of
//! its own, so that the motion core can forbid `unsafe`.

#![no_std]

/// The square root, correctly rounded; NaN below zero.
///
/// ```
/// assert_eq!(sinew_fpu::sqrt(2.25), 1.5);
/// assert!(sinew_fpu::sqrt(-1.0).is_nan());
/// ```
#[inline]
pub fn sqrt(x: f32) -> f32 {
    // The target's name tells of the FPU, which stable Rust does not; nor does it know the FPU's registers by class
    // there, so the number goes through one of the core's.
    #[cfg(all(target_arch = "arm", target_abi = "eabihf"))]
    {
        let mut bits = x.to_bits();
        #[expect(unsafe_code, reason = "no safe word for the instruction on stable Rust")]
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
