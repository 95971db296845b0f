//! Finds packets in a stream of bytes.

use super::crc::Crc;
use super::frame::{
    BROADCAST, HEADER, MIN_LENGTH, PREFIX_LEN, Packet, STATUS, is_address, unstuff,
};
use crate::finder::{Finder, Framing};

/// A parser that finds packets in a stream, which may be split, damaged or joined anywhere. `N` is the length of the
/// longest packet that it accepts, in bytes on the wire; a header that announces a longer packet is ignored. An `N` of
/// 7 (header, id and length) or less does not compile.
///
/// After a damaged packet, the parser searches for a header from the second byte of that packet on. It thus finds a
/// whole packet that follows the damage, or even begins inside it. If a damaged length makes it wait for bytes that
/// never arrive, [`flush`](Self::flush) ends the wait.
///
/// ```
/// use sinew_servo_bus::dynamixel::Parser;
/// let mut parser = Parser::<64>::new();
/// let mut input: &[u8] = &[0xFF, 0xFF, 0xFD, 0x00, 1, 4, 0, 0x55, 0, 0xA1, 0x0C];
/// let packet = parser.next(&mut input).expect("the manual's status of servo 1");
/// assert_eq!((packet.id, packet.instruction, packet.params), (1, 0x55, &[0][..]));
/// ```
#[derive(Debug, Clone)]
pub struct Parser<const N: usize> {
    finder: Finder<N>,
    last_damaged: Option<(u8, u8)>,
}

impl<const N: usize> Default for Parser<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Parser<N> {
    /// Creates a parser with an empty buffer.
    pub const fn new() -> Self {
        Self { finder: Finder::new(), last_damaged: None }
    }

    /// Returns the next packet. Consumes only the bytes that it needs, or all of `input` if it finds no packet.
    ///
    /// Cost: reads each byte once, and up to `N` bytes again for each damaged packet.
    pub fn next(&mut self, input: &mut &[u8]) -> Option<Packet<'_>> {
        self.find(input, false)
    }

    /// Returns the next packet in the buffer when no more bytes will arrive: the line has been silent for longer than
    /// one byte takes. Call it until it returns `None`.
    pub fn flush(&mut self) -> Option<Packet<'_>> {
        self.find(&mut &[][..], true)
    }

    /// Discards all buffered bytes.
    pub fn clear(&mut self) {
        self.finder.clear();
    }

    /// Returns the number of packets with a wrong CRC or a missing end.
    pub fn damaged(&self) -> u32 {
        self.finder.damaged()
    }

    /// Returns id and instruction of the last packet with a wrong CRC since the previous call, or `None`.
    pub fn take_damaged(&mut self) -> Option<(u8, u8)> {
        self.last_damaged.take()
    }

    fn find(&mut self, input: &mut &[u8], at_end: bool) -> Option<Packet<'_>> {
        let Self { finder, last_damaged } = self;
        let bytes = finder.next::<Protocol2>(input, at_end, |damaged| {
            let field = |index| damaged.get(index).copied();
            *last_damaged = field(4).zip(field(PREFIX_LEN));
        })?;
        let id = bytes.get(4).copied()?;
        let end = bytes.len().checked_sub(2)?;
        let body = bytes.get_mut(PREFIX_LEN..end)?;
        let instruction = body.first().copied()?;
        // A fast reply is not stuffed: it contains CRCs that are computed over the bytes of the wire.
        let len = if id == BROADCAST && instruction == STATUS { body.len() } else { unstuff(body) };
        Some(Packet { id, instruction, params: body.get(1..len)? })
    }
}

struct Protocol2;

impl Framing for Protocol2 {
    const PREFIX_LEN: usize = PREFIX_LEN;

    fn announced(bytes: &[u8]) -> Option<usize> {
        if bytes.iter().zip(HEADER).any(|(byte, expected)| *byte != expected) {
            return None;
        }
        let &[_, _, _, _, id, low, high, ..] = bytes else { return Some(PREFIX_LEN) };
        let length = usize::from(u16::from_le_bytes([low, high]));
        (is_address(id) && length >= MIN_LENGTH).then_some(PREFIX_LEN.saturating_add(length))
    }

    fn is_whole(packet: &[u8]) -> bool {
        let Some((body, crc)) = packet.split_last_chunk::<2>() else { return false };
        Crc::of(body) == u16::from_le_bytes(*crc)
    }
}
