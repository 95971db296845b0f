//! A run of [`sinew_parity::run`] on QEMU's `mps2-an386`, with or without its floating-point unit: as it is
//! compiled. Standard input and output are the host's, by semihosting.

use core::ffi::CStr;

use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, heprintln, syscall};
use sinew_parity::run;
use static_cell::ConstStaticCell;

use crate::{CAPACITY, LONGEST_SHOW};

#[entry]
fn main() -> ! {
    match perform() {
        Ok(()) => debug::exit(debug::EXIT_SUCCESS),
        Err(problem) => {
            heprintln!("error: {}", problem);
            debug::exit(debug::EXIT_FAILURE);
        }
    }
    loop {
        cortex_m::asm::wfi();
    }
}

fn perform() -> Result<(), &'static str> {
    const READ_BINARY: usize = 1;
    const WRITE_BINARY: usize = 5;
    static SHOW: ConstStaticCell<[u8; LONGEST_SHOW]> = ConstStaticCell::new([0; LONGEST_SHOW]);
    let input = open(c"/dev/stdin", READ_BINARY)?;
    let output = open(c"/dev/stdout", WRITE_BINARY)?;
    run::perform::<CAPACITY>(SHOW.take(), |bytes| read(input, bytes), |bytes| write(output, bytes))
}

/// Opens a file of the host.
#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn open(path: &CStr, mode: usize) -> Result<usize, &'static str> {
    // SAFETY: SYS_OPEN reads the path, which ends with a zero byte, and its length without it.
    let handle = unsafe { syscall!(OPEN, path.as_ptr(), mode, path.count_bytes()) };
    if handle == usize::MAX { Err("the host's file cannot be opened") } else { Ok(handle) }
}

#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn read(handle: usize, bytes: &mut [u8]) -> Result<(), &'static str> {
    // SAFETY: SYS_READ writes at most `bytes.len()` bytes to the address, both of one live slice.
    let left = unsafe { syscall!(READ, handle, bytes.as_mut_ptr(), bytes.len()) };
    if left == 0 { Ok(()) } else { Err("the run ends too early") }
}

#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn write(handle: usize, bytes: &[u8]) -> Result<(), &'static str> {
    // SAFETY: SYS_WRITE reads `bytes.len()` bytes from the address, both of one live slice.
    let left = unsafe { syscall!(WRITE, handle, bytes.as_ptr(), bytes.len()) };
    if left == 0 { Ok(()) } else { Err("the answer cannot be written") }
}

#[panic_handler]
fn panic(info: &core::panic::PanicInfo<'_>) -> ! {
    heprintln!("{}", info);
    loop {
        debug::exit(debug::EXIT_FAILURE);
    }
}
