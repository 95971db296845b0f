//! Finds packets in a stream of bytes.

use super::frame::{BROADCAST, MIN_LENGTH, PREFIX_LEN, Packet, checksum};
use crate::finder::{Finder, Framing};

/// A parser that finds packets in a stream, which may be split, damaged or joined anywhere. `N` is the length of the
/// longest packet that it accepts, in bytes; the protocol allows at most 259. An `N` of 4 (header, id and length) or
/// less does not compile.
///
/// After a damaged packet, the parser searches for a header from the second byte of that packet on.
#[derive(Debug, Clone)]
pub struct Parser<const N: usize> {
    finder: Finder<N>,
}

impl<const N: usize> Default for Parser<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Parser<N> {
    /// Creates a parser with an empty buffer.
    pub const fn new() -> Self {
        Self { finder: Finder::new() }
    }

    /// Returns the next packet. Consumes only the bytes that it needs, or all of `input` if it finds no packet.
    ///
    /// Cost: reads each byte once, and up to `N` bytes again for each damaged packet.
    pub fn next(&mut self, input: &mut &[u8]) -> Option<Packet<'_>> {
        self.find(input, false)
    }

    /// Returns the next packet in the buffer when no more bytes will arrive. Call it until it returns `None`.
    pub fn flush(&mut self) -> Option<Packet<'_>> {
        self.find(&mut &[][..], true)
    }

    /// Discards all buffered bytes.
    pub fn clear(&mut self) {
        self.finder.clear();
    }

    /// Returns the number of packets with a wrong sum or a missing end.
    pub fn damaged(&self) -> u32 {
        self.finder.damaged()
    }

    fn find(&mut self, input: &mut &[u8], at_end: bool) -> Option<Packet<'_>> {
        let bytes = self.finder.next::<Feetech>(input, at_end, |_| ())?;
        let (&mut [_, _, id, _, code], rest) = bytes.split_first_chunk_mut::<5>()?;
        rest.split_last().map(|(_, params)| Packet { id, code, params })
    }
}

struct Feetech;

impl Framing for Feetech {
    const PREFIX_LEN: usize = PREFIX_LEN;

    fn announced(bytes: &[u8]) -> Option<usize> {
        match *bytes {
            [] | [0xFF] | [0xFF, 0xFF] => Some(PREFIX_LEN),
            [0xFF, 0xFF, id] if id <= BROADCAST => Some(PREFIX_LEN),
            [0xFF, 0xFF, id, length, ..] if id <= BROADCAST && length >= MIN_LENGTH => {
                Some(PREFIX_LEN.saturating_add(length.into()))
            }
            _ => None,
        }
    }

    fn is_whole(packet: &[u8]) -> bool {
        let sum = packet.get(2..).unwrap_or_default().split_last();
        sum.is_some_and(|(sum, body)| checksum(body) == *sum)
    }
}
