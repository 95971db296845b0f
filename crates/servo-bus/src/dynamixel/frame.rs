//! The frame of a packet: header, id, length, stuffing, CRC.

use super::crc::Crc;
use crate::EncodeError;
use crate::sink::Sink;

/// First bytes of every packet. The fourth byte is reserved, and never FD.
pub const HEADER: [u8; 4] = [0xFF, 0xFF, 0xFD, 0x00];
/// Id of a packet that is addressed to all servos.
pub const BROADCAST: u8 = 0xFE;
/// The largest id of a servo.
pub const MAX_ID: u8 = 0xFC;
/// Length of header, id and length field: the bytes that the length field does not count.
pub(super) const PREFIX_LEN: usize = 7;
/// Minimum value of the length field: instruction and CRC.
pub(super) const MIN_LENGTH: usize = 3;
/// Instruction byte of a reply.
pub const STATUS: u8 = 0x55;

/// A received packet with a correct CRC, with its stuffing removed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Id of the receiver, or in a reply of the sender.
    pub id: u8,
    /// Instruction byte; [`STATUS`] in a reply.
    pub instruction: u8,
    /// Parameters, without the CRC.
    pub params: &'a [u8],
}

/// A writer of one packet, which stuffs the packet while writing.
pub struct FrameWriter<'a> {
    sink: Sink<'a>,
    run: Run,
    id_ok: bool,
}

impl<'a> FrameWriter<'a> {
    /// Begins a packet to or from servo `id`.
    pub fn new(out: &'a mut [u8], id: u8, instruction: u8) -> Self {
        let mut sink = Sink::new(out);
        sink.extend(&HEADER);
        sink.extend(&[id, 0, 0]);
        let mut frame = Self { sink, run: Run::default(), id_ok: is_address(id) };
        frame.push(instruction);
        frame
    }

    /// Appends a parameter byte, and a stuffing byte if the bytes would begin a packet.
    pub fn push(&mut self, byte: u8) {
        self.sink.push(byte);
        if self.run.completes_header(byte) {
            self.sink.push(0xFD);
        }
    }

    /// Appends parameter bytes.
    pub fn extend(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.push(*byte);
        }
    }

    /// Appends a number, low byte first.
    pub fn push_u16(&mut self, value: u16) {
        self.extend(&value.to_le_bytes());
    }

    /// Writes length and CRC, and returns the length of the packet.
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

/// Returns whether a packet can have this id.
pub(super) fn is_address(id: u8) -> bool {
    id <= MAX_ID || id == BROADCAST
}

/// Removes the stuffing in place, and returns the new length.
///
/// An unstuffed FF FF FD stays as it is, unless an FD follows it: that FD is lost. This happens with packets from
/// Python's `dynamixel-sdk` 4.1.0, which does not stuff. Real servos have the same ambiguity.
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

/// Number of FF bytes directly before the next byte, at most 2.
#[derive(Debug, Clone, Copy, Default)]
struct Run(u8);

impl Run {
    fn completes_header(&mut self, byte: u8) -> bool {
        let complete = self.0 == 2 && byte == 0xFD;
        self.0 = if byte == 0xFF { self.0.saturating_add(1).min(2) } else { 0 };
        complete
    }
}
