//! Code for comparing machines bit by bit. It is not part of a product.
//!
//! - [`run`]: a run that any machine can make, and all its numbers;
//! - [`replay`]: a stand-in for servos, so that any machine can perform a show without servos, and a hash of its
//!   torques;
//! - [`play`]: a show performed with this stand-in, and a hash of the torques of each method;
//! - [`decode`]: a show that any machine can decode, and a hash of each second;
//! - [`answer`]: each of them, as the program `parity` on a host and as an image for an emulated board.
//!
//! # Files
//! - `run`, `decode`, `play`: the three requests; `replay`: the stand-in for servos.
//! - `host`, `image`, `files`: the program on a host; the image for QEMU; files of the host through semihosting.

#![no_std]
#![forbid(unsafe_code)]
#![deny(missing_docs)]

pub mod decode;
pub mod play;
pub mod replay;
pub mod run;

/// The first word (u32, little-endian) of a request for a [`run`].
pub const RUN: u32 = 0;
/// The first word of a request to [`decode`].
pub const DECODE: u32 = 1;
/// The first word of a request to [`play`].
pub const PLAY: u32 = 2;

/// Answers a request. The first word of the request selects its kind; the modules describe the rest of the request,
/// and the answer. Rigs have at most `BODIES` bodies and `DOFS` dofs, shows at most `COORDS` coordinates.
///
/// # Errors
/// The errors of `read` and `write`, or a description of the fault in the request.
pub fn answer<const BODIES: usize, const DOFS: usize, const COORDS: usize>(
    buffer: &mut [u8],
    mut read: impl FnMut(&mut [u8]) -> Result<(), &'static str>,
    write: impl FnMut(&[u8]) -> Result<(), &'static str>,
) -> Result<(), &'static str> {
    let mut word = [0; 4];
    read(&mut word)?;
    match u32::from_le_bytes(word) {
        RUN => run::perform::<BODIES, DOFS>(buffer, read, write),
        DECODE => decode::perform::<COORDS>(buffer, read, write),
        PLAY => play::perform::<BODIES, DOFS, COORDS>(buffer, read, write),
        _ => Err("no run, and no show to decode or to play, is asked for"),
    }
}
