//! The frame of a packet: header, id, length, checksum.

use crate::EncodeError;
use crate::sink::Sink;

/// Id of a packet that is addressed to all servos.
pub const BROADCAST: u8 = 0xFE;
/// The largest id of a servo.
pub const MAX_ID: u8 = 0xFD;
/// Length of header, id and length field.
pub(super) const PREFIX_LEN: usize = 4;
/// Minimum value of the length field: instruction and sum.
pub(super) const MIN_LENGTH: u8 = 2;

/// A received packet with a correct checksum.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Id of the receiver, or in a reply of the sender.
    pub id: u8,
    /// Instruction byte; in a reply the status.
    pub code: u8,
    /// Parameters, without the sum.
    pub params: &'a [u8],
}

/// Returns the inverted sum of the bytes between header and sum.
pub(super) fn checksum(bytes: &[u8]) -> u8 {
    !bytes.iter().fold(0_u8, |sum, byte| sum.wrapping_add(*byte))
}

/// A writer of one packet.
pub(super) struct FrameWriter<'a> {
    sink: Sink<'a>,
    id: u8,
}

impl<'a> FrameWriter<'a> {
    pub(super) fn new(out: &'a mut [u8], id: u8, code: u8) -> Self {
        let mut sink = Sink::new(out);
        sink.extend(&[0xFF, 0xFF, id, 0, code]);
        Self { sink, id }
    }

    pub(super) fn extend(&mut self, bytes: &[u8]) {
        self.sink.extend(bytes);
    }

    pub(super) fn finish(mut self) -> Result<usize, EncodeError> {
        if self.id > BROADCAST {
            return Err(EncodeError::Id(self.id));
        }
        let length = self.sink.written().len().saturating_sub(PREFIX_LEN).saturating_add(1);
        let Ok(length) = u8::try_from(length) else { return Err(EncodeError::Length) };
        self.sink.set(3, length);
        let sum = checksum(self.sink.written().get(2..).unwrap_or_default());
        self.sink.extend(&[sum]);
        self.sink.finish()
    }
}
