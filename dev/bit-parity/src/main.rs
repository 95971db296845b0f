//! The program that each machine runs to be compared: a request of [`sinew_bit_parity::answer`] on standard input, the
//! answer on standard output.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod files;
#[cfg(not(target_os = "none"))]
mod host;
#[cfg(target_os = "none")]
mod image;

/// Bodies of the human figure.
const BODIES: usize = 18;

/// Its degrees of freedom: a free root, and ball joints.
const DOFS: usize = 6 + 3 * (BODIES - 1);

/// Coordinates of the largest show, which is the figure's: quaternions have four numbers.
const COORDINATES: usize = 7 + 4 * (BODIES - 1);

/// Bytes of the longest show, and of the frames of the longest run.
const BUFFER_LEN: usize = 3 << 20;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::main()
}
