//! From a stream of bytes, cut anywhere and with anything in it, to messages.

use core::fmt;
use core::marker::PhantomData;

use cobs::{DecodeResult, DecoderState};

use crate::frame::{BODY_MAX, CRC_LEN, Message, crc32};

/// Finds messages in a stream. It has room for one frame, and needs no time-out.
///
/// A frame has a zero at both ends and none inside. So damage spoils the frame that it is in, and no other; after
/// garbage the next frame is found.
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

/// Frames that did not become a message, by what was wrong with them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Damage {
    /// A zero came where the frame had to go on.
    pub cut: u32,
    /// Longer than a frame can be.
    pub too_long: u32,
    /// Too short to be anything.
    pub too_short: u32,
    /// The CRC is not that of the body.
    pub crc: u32,
    /// Whole, but of the other direction: an echo, or both ends are hosts.
    pub direction: u32,
    /// Whole, but no message of this version: an unknown kind, a number that is not finite, a list that is too long,
    /// or bytes left over.
    pub message: u32,
}

impl Damage {
    /// All kinds together.
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
    /// Waits for a frame.
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

    /// Takes one byte, and returns the message that ends with it. O(1), and O(length) at the end of a frame.
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

    /// Takes bytes, and gives each message that ends in them to `take`.
    pub fn feed(&mut self, bytes: &[u8], mut take: impl FnMut(M)) {
        for &byte in bytes {
            if let Some(message) = self.push(byte) {
                take(message);
            }
        }
    }

    /// How many messages came.
    pub fn messages(&self) -> u32 {
        self.messages
    }

    /// What did not become a message.
    pub fn damage(&self) -> Damage {
        self.damage
    }

    fn begin(&mut self) {
        self.len = 0;
        self.too_long = false;
    }

    /// The message of a whole frame in the buffer.
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

/// The message of a body, or the count of what is wrong.
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
