//! Fast sync and bulk read: all servos answer in one packet, one after the other.
//!
//! `FF FF FD 00 FE LEN_L LEN_H 55`, then for each servo `error, id, data, CRC`. Each CRC covers all bytes from the
//! first byte of the packet to the CRC itself, so the last CRC is also the packet's. The answer is not stuffed. A
//! reader must therefore not search for headers in it: it computes all lengths from the request. The parts before an
//! interruption are still valid.

use super::crc::Crc;
use super::frame::{BROADCAST, HEADER, PREFIX_LEN, STATUS};
use super::status::{Status, StatusError};
use crate::EncodeError;
use crate::sink::Sink;

/// Length of header, id, length and instruction.
const HEAD_LEN: usize = 8;
/// Length of error, id and CRC of each servo.
const EACH_LEN: usize = 4;

/// Returns the length of the whole answer, given the number of data bytes of each servo.
pub fn answer_len(lengths: impl Iterator<Item = u16>) -> usize {
    lengths.fold(HEAD_LEN, |sum, length| sum.saturating_add(EACH_LEN).saturating_add(length.into()))
}

fn head(total: usize) -> [u8; HEAD_LEN] {
    let length = u16::try_from(total.saturating_sub(PREFIX_LEN)).unwrap_or(u16::MAX);
    let ([a, b, c, d], [low, high]) = (HEADER, length.to_le_bytes());
    [a, b, c, d, BROADCAST, low, high, STATUS]
}

/// A search for the head of an answer of known length. It computes the CRC from there on.
#[derive(Debug, Clone)]
struct Head {
    expected: [u8; HEAD_LEN],
    seen: [u8; HEAD_LEN],
    found: bool,
    crc: Crc,
}

impl Head {
    fn new(total: usize) -> Self {
        Self { expected: head(total), seen: [0; HEAD_LEN], found: false, crc: Crc::default() }
    }

    /// Adds one byte that arrived before the first block.
    fn push(&mut self, byte: u8) {
        let [_, a, b, c, d, e, f, g] = self.seen;
        self.seen = [a, b, c, d, e, f, g, byte];
        if self.seen == self.expected {
            self.found = true;
            self.crc = Crc::default();
            self.crc.extend(&self.expected);
        }
    }
}

/// A reader that splits the answer into the parts of the servos while it arrives. `N` is the size of the largest part:
/// data plus 4 bytes.
#[derive(Debug, Clone)]
pub struct FastReader<const N: usize> {
    head: Head,
    block: [u8; N],
    len: usize,
    broken: bool,
}

impl<const N: usize> FastReader<N> {
    /// Creates a reader for an answer of `total` bytes, see [`answer_len`].
    pub fn new(total: usize) -> Self {
        Self { head: Head::new(total), block: [0; N], len: 0, broken: false }
    }

    /// Returns the next servo's part as soon as it has arrived completely. It must have this `id` and `length` data
    /// bytes. Consumes as much of `input` as it needs.
    ///
    /// After a wrong id or CRC it returns nothing more: all later CRCs cover the damaged bytes too.
    pub fn next(&mut self, id: u8, length: u16, input: &mut &[u8]) -> Option<Status<'_>> {
        let total = usize::from(length).saturating_add(EACH_LEN);
        let checked = total.saturating_sub(2);
        if total > N {
            self.broken = true;
        }
        while !self.broken {
            let (byte, rest) = input.split_first()?;
            *input = rest;
            if !self.head.found {
                self.head.push(*byte);
                continue;
            }
            if self.len < checked {
                self.head.crc.push(*byte);
            }
            if let Some(slot) = self.block.get_mut(self.len) {
                *slot = *byte;
            }
            self.len = self.len.saturating_add(1);
            if self.len == total {
                return self.end_block(id, total);
            }
        }
        None
    }

    /// Returns whether the rest of the answer is lost.
    pub fn is_broken(&self) -> bool {
        self.broken
    }

    fn end_block(&mut self, id: u8, total: usize) -> Option<Status<'_>> {
        self.len = 0;
        let (body, crc) = self.block.get(..total)?.split_last_chunk::<2>()?;
        let (&[error, from], data) = body.split_first_chunk::<2>()?;
        if from != id || u16::from_le_bytes(*crc) != self.head.crc.value() {
            self.broken = true;
            return None;
        }
        self.head.crc.extend(crc);
        Some(Status { id, error: StatusError::from_byte(error), data })
    }
}

/// A servo's position in the answer: it listens until its turn, then adds its part.
#[derive(Debug, Clone)]
pub struct FastTurn {
    head: Head,
    is_first: bool,
    /// Bytes after the head that other servos still send before this one.
    before: usize,
}

impl FastTurn {
    /// Creates the turn from the data lengths of the servos before this one, and of all servos.
    pub fn new(before: impl Iterator<Item = u16> + Clone, all: impl Iterator<Item = u16>) -> Self {
        let is_first = before.clone().next().is_none();
        let before = answer_len(before).saturating_sub(HEAD_LEN);
        Self { head: Head::new(answer_len(all)), is_first, before }
    }

    /// Counts one byte that was received from the line.
    pub fn hear(&mut self, byte: u8) {
        if !self.head.found {
            self.head.push(byte);
        } else if self.before > 0 {
            self.head.crc.push(byte);
            self.before = self.before.saturating_sub(1);
        }
    }

    /// Returns whether no servo answers before this one.
    pub fn is_first(&self) -> bool {
        self.is_first
    }

    /// Returns whether it is this servo's turn.
    pub fn is_due(&self) -> bool {
        self.is_first || (self.head.found && self.before == 0)
    }

    /// Writes this servo's part. The part of the first servo begins with the head.
    ///
    /// # Errors
    /// [`EncodeError`] if the part does not fit in `out`.
    pub fn encode(&self, status: &Status<'_>, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut sink = Sink::new(out);
        let mut crc = self.head.crc;
        if self.is_first {
            sink.extend(&self.head.expected);
        }
        sink.extend(&[status.error.byte(), status.id]);
        sink.extend(status.data);
        crc.extend(sink.written());
        sink.extend(&crc.value().to_le_bytes());
        sink.finish()
    }
}
