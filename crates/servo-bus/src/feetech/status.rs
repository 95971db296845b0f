//! Replies of Feetech servos.

use super::frame::{FrameWriter, Packet};
use crate::EncodeError;

/// Status bits of a servo: in every reply, and at address 65.
pub mod status_bit {
    /// The supply is outside of its limits.
    pub const VOLTAGE: u8 = 1 << 0;
    /// The encoder fails.
    pub const ENCODER: u8 = 1 << 1;
    /// The temperature is too high.
    pub const TEMPERATURE: u8 = 1 << 2;
    /// The current is too high.
    pub const CURRENT: u8 = 1 << 3;
    /// The load was too high for too long: the servo reduces its torque to a fifth.
    pub const OVERLOAD: u8 = 1 << 5;
}

/// A bit that no servo sets: a reply with this bit is damaged. Feetech's own clients refuse it too.
const NEVER: u8 = 1 << 7;

/// The reply of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status<'a> {
    /// Id of the servo that replied.
    pub id: u8,
    /// Faults of the servo, see [`status_bit`].
    pub bits: u8,
    /// The bytes that were read.
    pub data: &'a [u8],
}

impl<'a> Status<'a> {
    /// Interprets a packet as a reply, or returns `None` if it cannot be a reply.
    pub fn of(packet: Packet<'a>) -> Option<Self> {
        (packet.code & NEVER == 0).then_some(Self {
            id: packet.id,
            bits: packet.code,
            data: packet.params,
        })
    }

    /// Writes the reply.
    ///
    /// # Errors
    /// [`EncodeError`] if the reply does not fit in `out`.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut frame = FrameWriter::new(out, self.id, self.bits);
        frame.extend(self.data);
        frame.finish()
    }

    /// Returns whether this is a valid answer of servo `id` to a request for `len` bytes.
    pub fn answers(&self, id: u8, len: usize) -> bool {
        self.id == id && self.data.len() == len
    }
}
