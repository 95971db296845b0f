//! Shared parts of the images of `cargo xtask audit`: values that are unknown to the compiler, and a panic handler
//! that calls a missing function.
//!
//! # Files
//! - `main`, `image/`: the image of everything that a board may call, one file for each crate or subject.
//! - `bin/faults`: the image of faults that the audit must find.

#![no_std]

use core::hint::black_box;

/// Returns a slice of unknown length and content.
pub fn slice<T>() -> &'static [T] {
    black_box(&[])
}

/// Returns a writable slice of unknown length and content.
pub fn slice_mut<T>() -> &'static mut [T] {
    black_box(&mut [])
}

#[cfg(target_os = "none")]
mod panic {
    #[expect(unsafe_code, reason = "nothing is behind it that could be unsafe")]
    unsafe extern "C" {
        /// A function that does not exist: code that needs it does not link.
        safe fn a_panic_can_be_reached() -> !;
    }

    #[panic_handler]
    fn panic(_: &core::panic::PanicInfo<'_>) -> ! {
        a_panic_can_be_reached()
    }
}
