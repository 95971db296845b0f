//! An image with one example of each fault that the audit must find, to test the audit. On a host there is nothing to
//! run.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod image {
    use core::fmt::Write;
    use core::hint::black_box;

    use cortex_m_rt::entry;
    use sinew_audit::slice;

    #[entry]
    fn main() -> ! {
        loop {
            index();
            double();
            fused();
            text();
            recursion();
            pointer();
        }
    }

    /// Contains a panic.
    #[inline(never)]
    pub(crate) fn index() {
        let items: &[u32] = slice();
        black_box(items[black_box(3)]);
    }

    /// Contains arithmetic with 64-bit floats.
    #[inline(never)]
    pub(crate) fn double() {
        black_box(black_box(1.5f64) * black_box(2.5f64));
    }

    /// Contains a fused multiply-add, which the compiler never generates from Rust code. The function may use these
    /// registers, because callers save them.
    #[unsafe(naked)]
    pub(crate) extern "C" fn fused() {
        core::arch::naked_asm!("vfma.f32 s0, s1, s2", "bx lr")
    }

    /// Contains formatting.
    #[inline(never)]
    pub(crate) fn text() {
        struct Sink;
        impl Write for Sink {
            fn write_str(&mut self, text: &str) -> core::fmt::Result {
                black_box(text);
                Ok(())
            }
        }
        let _ = write!(Sink, "{}", black_box(1.5f32));
    }

    /// Contains a recursion that cannot become a loop.
    #[inline(never)]
    pub(crate) fn recursion() {
        black_box(factorial(black_box(5)));
    }

    fn factorial(n: u32) -> u32 {
        if n == 0 { 1 } else { black_box(factorial(black_box(n.wrapping_sub(1)))).wrapping_mul(n) }
    }

    /// Contains a call by pointer.
    #[inline(never)]
    pub(crate) fn pointer() {
        let function: fn() = black_box(double);
        function();
    }
}

#[cfg(not(target_os = "none"))]
fn main() {}
