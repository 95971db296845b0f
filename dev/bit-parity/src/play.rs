//! Performs a show on any machine, with a [stand-in](crate::replay) for servos, and a hash of all torques.
//!
//! # Format
//! All numbers are little-endian.
//!
//! | bytes | content |
//! | --- | --- |
//! | u32 | ticks t, one for each sample of the show |
//! | u32 | length r of the rig in bytes |
//! | u32 | length s of the show in bytes |
//! | r | the rig, without servos, see [`sinew_rig::board`] |
//! | s | the show, see [`sinew_show`] |
//!
//! The answer is a u64 for each of the [`METHODS`]: the hash of its torques in the first t ticks.

use sinew_show::Show;

use crate::replay::{METHODS, hash, tree};

/// Performs a show of at most `COORDS` coordinates, on a rig of at most `BODIES` bodies and `DOFS` dofs: `read` fills
/// its slice with the next bytes of the request, `write` receives the next bytes of the answer. Rig and show are
/// stored in `buffer`.
///
/// # Errors
/// The errors of `read` and `write`, or a description of the fault in the request.
pub fn perform<const BODIES: usize, const DOFS: usize, const COORDS: usize>(
    buffer: &mut [u8],
    mut read: impl FnMut(&mut [u8]) -> Result<(), &'static str>,
    mut write: impl FnMut(&[u8]) -> Result<(), &'static str>,
) -> Result<(), &'static str> {
    let mut number = || {
        let mut bytes = [0; 4];
        read(&mut bytes)?;
        Ok::<_, &'static str>(u32::from_le_bytes(bytes))
    };
    let (ticks, rig_len, show_len) = (number()?, number()?, number()?);
    let length = |bytes: u32| usize::try_from(bytes).map_err(|_| "a length is too large");
    let rig = buffer.get_mut(..length(rig_len)?).ok_or("the rig is longer than the buffer")?;
    read(rig)?;
    let tree = tree::<BODIES, DOFS>(rig).map_err(|_| "the rig is not usable")?;
    let show = buffer.get_mut(..length(show_len)?).ok_or("the show is longer than the buffer")?;
    read(show)?;
    let show = Show::open(show).map_err(|_| "the show is not valid")?;
    for method in METHODS {
        let hash = hash::<BODIES, COORDS>(&tree, show, method, ticks);
        let hash = hash.map_err(|_| "the show cannot be performed by the rig")?;
        write(&hash.to_le_bytes())?;
    }
    Ok(())
}
