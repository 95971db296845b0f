//! Decodes messages from a stream of bytes, which may be cut anywhere and may contain garbage.

use core::fmt;
use core::marker::PhantomData;

use cobs::{DecodeResult, DecoderState};

use crate::frame::{BODY_MAX, CRC_LEN, Message, crc32};

/// A decoder that finds messages in a stream. It stores a single frame, and needs no time-out.
///
/// A frame starts and ends with a zero and contains no other zero. Damage therefore affects only the frame it is in,
/// and after garbage the next frame is found.
pub struct Decoder<M> {
    state: DecoderState,
    buffer: [u8; BODY_MAX + CRC_LEN],
    len: usize,
    too_long: bool,
    messages: u32,
    damage: Damage,
    of: PhantomData<fn() -> M>,
}

impl<M> fmt::Debug for Decoder<M> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Decoder")
            .field("len", &self.len)
            .field("messages", &self.messages)
            .field("damage", &self.damage)
            .finish_non_exhaustive()
    }
}

/// Counts of frames that did not become a message, by the kind of damage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// Frames with a zero in the middle.
    pub cut: u32,
    /// Frames longer than the maximum.
    pub too_long: u32,
    /// Frames too short for a body and a CRC.
    pub too_short: u32,
    /// Frames whose CRC does not match the body.
    pub crc: u32,
    /// Intact frames of the other direction: the line echoes, or both ends are hosts.
    pub direction: u32,
    /// Intact frames that are not a message of this version: an unknown kind, a number that is not finite, a list
    /// that is too long, or extra bytes.
    pub message: u32,
}

impl Damage {
    /// Returns the sum of all counts.
    pub fn total(&self) -> u32 {
        let Self { cut, too_long, too_short, crc, direction, message } = *self;
        [too_long, too_short, crc, direction, message].into_iter().fold(cut, u32::saturating_add)
    }
}

impl<M: Message> Default for Decoder<M> {
    fn default() -> Self {
        Self::new()
    }
}

impl<M: Message> Decoder<M> {
    /// Creates a decoder that waits for a frame.
    pub const fn new() -> Self {
        Self {
            state: DecoderState::Idle,
            buffer: [0; BODY_MAX + CRC_LEN],
            len: 0,
            too_long: false,
            messages: 0,
            damage: Damage { cut: 0, too_long: 0, too_short: 0, crc: 0, direction: 0, message: 0 },
            of: PhantomData,
        }
    }

    /// Accepts a byte, and returns the message that ends with it, if any. O(1), and O(length) at the end of a frame.
    pub fn push(&mut self, byte: u8) -> Option<M> {
        match self.state.feed(byte) {
            Ok(DecodeResult::NoData) => None,
            Ok(DecodeResult::DataContinue(byte)) => {
                match self.buffer.get_mut(self.len) {
                    Some(place) => {
                        *place = byte;
                        self.len = self.len.saturating_add(1);
                    }
                    None => self.too_long = true,
                }
                None
            }
            Ok(DecodeResult::DataComplete) => {
                let message = self.finish();
                self.begin();
                message
            }
            Err(_) => {
                let kind =
                    if self.too_long { &mut self.damage.too_long } else { &mut self.damage.cut };
                *kind = kind.saturating_add(1);
                self.begin();
                None
            }
        }
    }

    /// Accepts bytes, and passes each message that ends in them to `take`.
    pub fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(M)) {
        for &byte in bytes {
            if let Some(message) = self.push(byte) {
                take(message);
            }
        }
    }

    /// Returns the number of decoded messages.
    pub fn messages(&self) -> u32 {
        self.messages
    }

    /// Returns the counts of frames that did not become a message.
    pub fn damage(&self) -> Damage {
        self.damage
    }

    fn begin(&mut self) {
        self.len = 0;
        self.too_long = false;
    }

    /// Decodes the frame in the buffer.
    fn finish(&mut self) -> Option<M> {
        let result = if self.too_long {
            Err(&mut self.damage.too_long)
        } else {
            let frame = self.buffer.get(..self.len).unwrap_or_default();
            match frame.split_last_chunk::<CRC_LEN>() {
                Some((body, crc)) if !body.is_empty() => message(body, *crc, &mut self.damage),
                _ => Err(&mut self.damage.too_short),
            }
        };
        match result {
            Ok(message) => {
                self.messages = self.messages.saturating_add(1);
                Some(message)
            }
            Err(kind) => {
                *kind = kind.saturating_add(1);
                None
            }
        }
    }
}

/// Decodes a body, or returns the count that the damage belongs to.
fn message<'a, M: Message>(
    body: &[u8],
    crc: [u8; CRC_LEN],
    damage: &'a mut Damage,
) -> Result<M, &'a mut u32> {
    if crc32(body) != crc {
        return Err(&mut damage.crc);
    }
    match body.split_first() {
        Some((&direction, rest)) if direction == M::DIRECTION => {
            match postcard::take_from_bytes(rest) {
                Ok((message, [])) => Ok(message),
                _ => Err(&mut damage.message),
            }
        }
        _ => Err(&mut damage.direction),
    }
}
