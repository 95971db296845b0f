//! Decodes a show tick by tick on any machine, with a hash of all bits of each second.
//!
//! # Format
//! All numbers are little-endian.
//!
//! | bytes | content |
//! | --- | --- |
//! | u32 | ticks per second |
//! | u32 | length s of the show in bytes |
//! | s | the show, version 2, see [`sinew_show`] |
//!
//! The answer is a u64 for each second: FNV-1a over the bits of positions, speeds and accelerations, f32 by f32. The
//! last second may be incomplete.

use sinew_show::{Player, Show};

/// Decodes a show of at most `COORDS` coordinates: `read` fills its slice with the next bytes of the request, `write`
/// receives the next bytes of the answer. The show is stored in `buffer`.
///
/// # Errors
/// The errors of `read` and `write`, or a description of the fault in the request.
pub fn perform<const COORDS: usize>(
    buffer: &mut [u8],
    mut read: impl FnMut(&mut [u8]) -> Result<(), &'static str>,
    mut write: impl FnMut(&[u8]) -> Result<(), &'static str>,
) -> Result<(), &'static str> {
    let mut number = || {
        let mut bytes = [0; 4];
        read(&mut bytes)?;
        Ok(u32::from_le_bytes(bytes))
    };
    let (rate_hz, length) = (number()?, number()?);
    let length = usize::try_from(length).map_err(|_| "the show is longer than the buffer")?;
    let show = buffer.get_mut(..length).ok_or("the show is longer than the buffer")?;
    read(show)?;
    let show = Show::open(show).map_err(|_| "the show is not valid")?;
    let mut player =
        Player::<COORDS>::new(show).map_err(|_| "the show has too many coordinates")?;
    let (nq, nv) = (show.channel_count(), show.dof_count());
    let pace = show.pace(1.0 / rate_hz.max(1) as f32);
    let [mut q, mut qd, mut qdd] = [[0.0; COORDS]; 3];
    let (mut tick, mut hash) = (0, NOTHING);
    loop {
        let position = pace.position(tick);
        let is_over = position.sample() >= show.length();
        if is_over || tick > 0 && tick.is_multiple_of(rate_hz.max(1)) {
            write(&hash.to_le_bytes())?;
            hash = NOTHING;
        }
        if is_over {
            return Ok(());
        }
        player
            .state_at(position, &mut q, &mut qd, &mut qdd)
            .map_err(|_| "a block of the show is damaged")?;
        for (numbers, count) in [(&q, nq), (&qd, nv), (&qdd, nv)] {
            hash = numbers.iter().take(count).fold(hash, |hash, x| add(hash, x.to_bits()));
        }
        tick += 1;
    }
}

/// The hash of no data.
const NOTHING: u64 = 0xcbf2_9ce4_8422_2325;

fn add(hash: u64, word: u32) -> u64 {
    (hash ^ u64::from(word)).wrapping_mul(0x100_0000_01b3)
}
