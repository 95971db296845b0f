//! The program that each machine runs to be compared: a request of [`sinew_bit_parity::answer`] on standard input, the
//! answer on standard output.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod files;
#[cfg(not(target_os = "none"))]
mod host;
#[cfg(target_os = "none")]
mod image;

/// Bodies of the figure.
const CAPACITY: usize = 18;

/// Coordinates of the largest show that is decoded.
const COORDINATES: usize = 20;

/// Bytes of the longest show.
const LONGEST_SHOW: usize = 3 << 20;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::main()
}
