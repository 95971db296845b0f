//! The program that is compared on each machine: it reads a request of [`sinew_bit_parity::answer`] from standard
//! input, and writes the answer to standard output.

#![cfg_attr(target_os = "none", no_std, no_main)]

#[cfg(target_os = "none")]
mod files;
#[cfg(not(target_os = "none"))]
mod host;
#[cfg(target_os = "none")]
mod image;

/// Number of bodies of the human figure.
const BODIES: usize = 18;

/// Number of dofs of the human figure: a free root, and ball joints.
const DOFS: usize = 6 + 3 * (BODIES - 1);

/// Number of coordinates of the largest show, which is that of the figure: a quaternion has four.
const COORDINATES: usize = 7 + 4 * (BODIES - 1);

/// Length of the longest show, and of the frames of the longest run, bytes.
const BUFFER_LEN: usize = 3 << 20;

#[cfg(not(target_os = "none"))]
fn main() -> std::process::ExitCode {
    host::main()
}
