//! Packets out of a stream of bytes.

use super::crc::Crc;
use super::frame::{
    BROADCAST, HEADER, MIN_LENGTH, PREFIX_LEN, Packet, STATUS, is_address, unstuff,
};
use crate::finder::{Finder, Framing};

/// Finds packets in a stream that may be split, damaged or joined anywhere. `N` is the longest packet that it takes, in
/// bytes on the wire; a header that announces more is no header. An `N` of 7 (header, id and length) or less does not
/// compile.
///
/// After a damaged packet it looks for a header from the second byte of that packet on: a whole packet behind it, or
/// even inside it, is found. Where a damaged length waits for bytes that never come, [`flush`](Self::flush) ends the
/// wait.
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
    /// A parser that has seen nothing.
    pub const fn new() -> Self {
        Self { finder: Finder::new(), last_damaged: None }
    }

    /// The next packet. Takes as much of `input` as it needs; all of it if there is no packet.
    ///
    /// Cost: each byte once, and up to `N` bytes again for each damaged packet.
    pub fn next(&mut self, input: &mut &[u8]) -> Option<Packet<'_>> {
        self.find(input, false)
    }

    /// The next packet in what has come, where nothing more will: the line has been silent for longer than a byte
    /// takes. Call it until there is none.
    pub fn flush(&mut self) -> Option<Packet<'_>> {
        self.find(&mut &[][..], true)
    }

    /// Forgets what has come so far.
    pub fn clear(&mut self) {
        self.finder.clear();
    }

    /// How many packets had a wrong CRC, or were cut short.
    pub fn damaged(&self) -> u32 {
        self.finder.damaged()
    }

    /// Id and instruction that stood in a packet of wrong CRC, if there was one since the last call.
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
        // A fast reply has CRCs inside, which run over the bytes of the wire: it is not stuffed.
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
