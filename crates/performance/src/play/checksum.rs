//! The checksum of a recording: SHA-256 of all bytes up to an end (footer) of the Parquet file, and of the end itself,
//! so that each flipped bit is detected.
//!
//! The checksum is stored in the end as text, under [`KEY`]. Zeros stand in its place while it is computed.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, Read as _, Seek as _, SeekFrom, Write};

use sha2::{Digest as _, Sha256};

/// Name of the checksum in the metadata of a recording.
pub(super) const KEY: &str = "sha256";
/// Text in the place of the checksum while it is computed.
pub(super) const NONE: &str = "0000000000000000000000000000000000000000000000000000000000000000";
/// Bytes between name and text in Thrift's compact protocol: the type of the field, and its length.
const BETWEEN: [u8; 2] = [0x18, 64];
/// Number of bytes that are read at once.
const BLOCK: usize = 1 << 16;

/// A writer that computes the checksum of the written bytes.
pub(super) struct Summed<W> {
    writer: W,
    sum: Sha256,
    /// Whether writing has ended; further bytes are ignored.
    pub(super) is_over: bool,
}

impl<W> Summed<W> {
    pub(super) fn new(writer: W) -> Self {
        Self { writer, sum: Sha256::new(), is_over: false }
    }

    pub(super) fn into_inner(self) -> W {
        self.writer
    }

    /// Writes the checksum of all written bytes and of this end into the end.
    pub(super) fn sign(&self, end: &mut [u8]) {
        let sum = text(self.sum.clone().chain_update(&*end));
        if let Some(place) = place(end).and_then(|place| end.get_mut(place..place + NONE.len())) {
            place.copy_from_slice(sum.as_bytes());
        }
    }
}

impl<W: Write> Write for Summed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_over {
            return Ok(bytes.len());
        }
        let count = self.writer.write(bytes)?;
        self.sum.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Returns whether the checksum in an end, from `begin` to `end`, matches the content of a file.
pub(super) fn fits(file: &mut File, [begin, end]: [u64; 2]) -> io::Result<bool> {
    file.seek(SeekFrom::Start(0))?;
    let (mut sum, mut left) = (Sha256::new(), begin);
    let mut block = vec![0; BLOCK];
    while left > 0 {
        let most = BLOCK.min(usize::try_from(left).unwrap_or(BLOCK));
        let count = file.read(&mut block[..most])?;
        if count == 0 {
            return Ok(false);
        }
        sum.update(&block[..count]);
        left -= count as u64;
    }
    let mut bytes = vec![0; usize::try_from(end - begin).unwrap_or_default()];
    file.read_exact(&mut bytes)?;
    let Some(place) = place(&bytes).map(|place| place..place + NONE.len()) else {
        return Ok(false);
    };
    let Some(told) = bytes.get(place.clone()).map(<[u8]>::to_vec) else { return Ok(false) };
    bytes[place].copy_from_slice(NONE.as_bytes());
    Ok(text(sum.chain_update(&bytes)).as_bytes() == told)
}

/// Returns the position of the checksum in the end of a file: after the last field with its name. `None` if there is no
/// such field.
fn place(end: &[u8]) -> Option<usize> {
    let before = [KEY.as_bytes(), &BETWEEN].concat();
    let found = end.windows(before.len()).rposition(|window| window == before)?;
    Some(found + before.len())
}

fn text(sum: Sha256) -> String {
    sum.finalize().iter().fold(String::new(), |mut text, byte| {
        let _ = write!(text, "{byte:02x}");
        text
    })
}
