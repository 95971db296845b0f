//! Files of the host that runs QEMU, through semihosting.

use core::ffi::CStr;

use cortex_m_semihosting::syscall;

/// Mode that opens a file for reading.
pub(crate) const READ: usize = 1;
/// Mode that opens a file for writing.
pub(crate) const WRITE: usize = 5;

/// Opens a file of the host.
#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
pub(crate) fn open(path: &CStr, mode: usize) -> Result<usize, &'static str> {
    // SAFETY: SYS_OPEN reads the path, which ends with a zero byte, and its length without it.
    let handle = unsafe { syscall!(OPEN, path.as_ptr(), mode, path.count_bytes()) };
    if handle == usize::MAX { Err("the host's file cannot be opened") } else { Ok(handle) }
}

/// Fills `bytes`. A pipe may deliver them in parts.
pub(crate) fn read(handle: usize, mut bytes: &mut [u8]) -> Result<(), &'static str> {
    while !bytes.is_empty() {
        let left = read_some(handle, bytes);
        let come = bytes.len().checked_sub(left).filter(|come| *come > 0);
        bytes = come.and_then(|come| bytes.get_mut(come..)).ok_or("the request ends too early")?;
    }
    Ok(())
}

/// Reads bytes, and returns the number of bytes that are missing.
#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
fn read_some(handle: usize, bytes: &mut [u8]) -> usize {
    // SAFETY: SYS_READ writes at most `bytes.len()` bytes to the address, both of one live slice.
    unsafe { syscall!(READ, handle, bytes.as_mut_ptr(), bytes.len()) }
}

/// Writes `bytes`.
#[expect(unsafe_code, reason = "a semihosting call is a breakpoint instruction with arguments")]
pub(crate) fn write(handle: usize, bytes: &[u8]) -> Result<(), &'static str> {
    // SAFETY: SYS_WRITE reads `bytes.len()` bytes from the address, both of one live slice.
    let left = unsafe { syscall!(WRITE, handle, bytes.as_ptr(), bytes.len()) };
    if left == 0 { Ok(()) } else { Err("the answer cannot be written") }
}
