//! The frame of every packet: header, id, length, stuffing, CRC.

use super::crc::Crc;
use crate::EncodeError;
use crate::sink::Sink;

/// Where every packet begins. The fourth byte is reserved, and never FD.
pub const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];
/// Id of a packet to all servos.
pub const BROADCAST: u8 = 0xFE;
/// The largest id of a servo.
pub const MAX_ID: u8 = 0xFC;
/// Header, id and length: what stands in front of the bytes that the length counts.
pub(super) const PREFIX_LEN: usize = 7;
/// The shortest length: instruction and CRC.
pub(super) const MIN_LENGTH: usize = 3;
/// The instruction byte of a reply.
pub const STATUS: u8 = 0x55;

/// A packet whose CRC was right, with its stuffing taken out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// From or to whom.
    pub id: u8,
    /// The instruction; [`STATUS`] for a reply.
    pub instruction: u8,
    /// What follows it, without the CRC.
    pub params: &'a [u8],
}

/// Writes one packet, and stuffs it on the way.
pub struct FrameWriter<'a> {
    sink: Sink<'a>,
    run: Run,
    id_ok: bool,
}

impl<'a> FrameWriter<'a> {
    /// Begins a packet.
    pub fn new(out: &'a mut [u8], id: u8, instruction: u8) -> Self {
        let mut sink = Sink::new(out);
        sink.extend(&HEADER);
        sink.extend(&[id, 0, 0]);
        let mut frame = Self { sink, run: Run::default(), id_ok: is_address(id) };
        frame.push(instruction);
        frame
    }

    /// Adds a parameter byte.
    pub fn push(&mut self, byte: u8) {
        self.sink.push(byte);
        if self.run.completes_header(byte) {
            self.sink.push(0xFD);
        }
    }

    /// Adds parameter bytes.
    pub fn extend(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.push(*byte);
        }
    }

    /// Adds a number, low byte first.
    pub fn push_u16(&mut self, value: u16) {
        self.extend(&value.to_le_bytes());
    }

    /// Writes length and CRC, and says how long the packet is.
    ///
    /// # Errors
    /// [`EncodeError`] if there was no room, the packet is too long or no servo can have the id.
    pub fn finish(mut self) -> Result<usize, EncodeError> {
        if !self.id_ok {
            return Err(EncodeError::Id(self.sink.written().get(4).copied().unwrap_or(BROADCAST)));
        }
        let length = self.sink.written().len().saturating_sub(PREFIX_LEN).saturating_add(2);
        let Ok(length) = u16::try_from(length) else { return Err(EncodeError::Length) };
        let [low, high] = length.to_le_bytes();
        self.sink.set(5, low);
        self.sink.set(6, high);
        let crc = Crc::of(self.sink.written());
        self.sink.extend(&crc.to_le_bytes());
        self.sink.finish()
    }
}

/// Whether a packet can come from or go to this id.
pub(super) fn is_address(id: u8) -> bool {
    id <= MAX_ID || id == BROADCAST
}

/// Takes the stuffing out, in place, and says how many bytes are left.
///
/// An FF FF FD that was sent without stuffing stays as it is, unless an FD follows it: that FD is lost. So it goes with
/// what Python's `dynamixel-sdk` 4.1.0 writes, which does not stuff. Real servos have the same ambiguity.
pub(super) fn unstuff(bytes: &mut [u8]) -> usize {
    let mut run = Run::default();
    let (mut from, mut to) = (0usize, 0usize);
    while let Some(&byte) = bytes.get(from) {
        from = from.saturating_add(1);
        if let Some(slot) = bytes.get_mut(to) {
            *slot = byte;
        }
        to = to.saturating_add(1);
        if run.completes_header(byte) && bytes.get(from) == Some(&0xFD) {
            from = from.saturating_add(1);
        }
    }
    to
}

/// How many FF stand before the next byte, two at most.
#[derive(Debug, Clone, Copy, Default)]
struct Run(u8);

impl Run {
    fn completes_header(&mut self, byte: u8) -> bool {
        let complete = self.0 == 2 && byte == 0xFD;
        self.0 = if byte == 0xFF { self.0.saturating_add(1).min(2) } else { 0 };
        complete
    }
}
