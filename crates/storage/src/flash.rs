//! Reads and writes bytes in flash: aligned, read back, never written twice in one place.

use core::iter::successors;

use crc::{CRC_32_ISO_HDLC, Crc, Digest};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

use crate::error::Error;

pub(crate) const CHECKSUM: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

/// Length and alignment of a read, in bytes, so that a driver may require any alignment up to this length.
pub(crate) const CHUNK: usize = 64;
/// Length of a read as a `u32`, see `CHUNK`.
pub(crate) const CHUNK_LEN: u32 = 64;

/// Returns the write granule, in bytes: the flash's write size, at least a word.
pub(crate) fn granule<F: NorFlash>() -> u32 {
    u32::try_from(F::WRITE_SIZE).unwrap_or(CHUNK_LEN).clamp(4, CHUNK_LEN)
}

/// Rounds a length up to whole granules. A granule is a power of two, which the table's check ensures.
pub(crate) fn padded<F: NorFlash>(len: u32) -> u32 {
    let mask = granule::<F>().saturating_sub(1);
    len.saturating_add(mask) & !mask
}

/// Reads from any address.
pub(crate) fn read<F: ReadNorFlash>(
    flash: &mut F,
    mut at: u32,
    mut out: &mut [u8],
) -> Result<(), Error<F::Error>> {
    let mut chunk = [0; CHUNK];
    while !out.is_empty() {
        let base = at & !CHUNK_LEN.saturating_sub(1);
        flash.read(base, &mut chunk).map_err(Error::Flash)?;
        let skip = at.saturating_sub(base);
        let found = chunk.iter().skip(skip as usize);
        for (to, from) in out.iter_mut().zip(found) {
            *to = *from;
        }
        let took = CHUNK_LEN.saturating_sub(skip);
        out = out.get_mut(took as usize..).unwrap_or_default();
        at = at.saturating_add(took);
    }
    Ok(())
}

/// Passes every byte of a range to `each`, in order, in parts. O(len).
pub(crate) fn scan<F: ReadNorFlash>(
    flash: &mut F,
    mut at: u32,
    mut len: u32,
    mut each: impl FnMut(&[u8]),
) -> Result<(), Error<F::Error>> {
    let mut chunk = [0; CHUNK];
    while len > 0 {
        let now = len.min(CHUNK_LEN);
        let part = chunk.get_mut(..now as usize).unwrap_or_default();
        read(flash, at, part)?;
        each(part);
        at = at.saturating_add(now);
        len = len.saturating_sub(now);
    }
    Ok(())
}

/// Adds a range to a CRC. O(len).
pub(crate) fn checksum<F: ReadNorFlash>(
    flash: &mut F,
    at: u32,
    len: u32,
    digest: &mut Digest<'_, u32>,
) -> Result<(), Error<F::Error>> {
    scan(flash, at, len, |part| digest.update(part))
}

/// Returns `true` if a range is erased. O(len).
pub(crate) fn is_blank<F: ReadNorFlash>(
    flash: &mut F,
    at: u32,
    len: u32,
) -> Result<bool, Error<F::Error>> {
    let mut blank = true;
    scan(flash, at, len, |part| blank &= all_ones(part))?;
    Ok(blank)
}

pub(crate) fn all_ones(bytes: &[u8]) -> bool {
    bytes.iter().all(|byte| *byte == 0xFF)
}

/// Writes bytes that are not already there, and reads them back. `at` is a multiple of the granule. The rest of the
/// last granule stays erased.
///
/// Nothing is written twice: if the flash is neither blank nor already holds the bytes, the result is
/// [`Error::Torn`].
pub(crate) fn fill<F: NorFlash>(
    flash: &mut F,
    at: u32,
    bytes: &[u8],
) -> Result<(), Error<F::Error>> {
    let granule = granule::<F>();
    for (part, at) in bytes.chunks(CHUNK).zip(steps(at, CHUNK_LEN)) {
        if fill_part(flash, at, part)? {
            continue;
        }
        // A power cut interrupted this part: continue granule by granule.
        for (word, at) in part.chunks(granule as usize).zip(steps(at, granule)) {
            if !fill_part(flash, at, word)? {
                return Err(Error::Torn { at });
            }
        }
    }
    Ok(())
}

/// Writes up to a chunk unless it is already there. Returns `false` if other data are in its place.
fn fill_part<F: NorFlash>(flash: &mut F, at: u32, part: &[u8]) -> Result<bool, Error<F::Error>> {
    let (mut wanted, mut found) = ([0xFF; CHUNK], [0; CHUNK]);
    for (to, from) in wanted.iter_mut().zip(part) {
        *to = *from;
    }
    let len = padded::<F>(u32::try_from(part.len()).unwrap_or(CHUNK_LEN)) as usize;
    let wanted = wanted.get(..len).unwrap_or_default();
    let found = found.get_mut(..len).unwrap_or_default();
    read(flash, at, found)?;
    if found == wanted {
        return Ok(true);
    }
    if !all_ones(found) {
        return Ok(false);
    }
    flash.write(at, wanted).map_err(Error::Flash)?;
    read(flash, at, found)?;
    if found == wanted { Ok(true) } else { Err(Error::ReadBack { at }) }
}

fn steps(from: u32, step: u32) -> impl Iterator<Item = u32> {
    successors(Some(from), move |at| at.checked_add(step))
}
