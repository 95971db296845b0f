//! Replies of servos.

use super::frame::{FrameWriter, Packet};
use crate::EncodeError;

/// Status of a servo, bit by bit: in every reply, and at address 65.
pub mod status_bit {
    /// The supply is outside of its limits.
    pub const VOLTAGE: u8 = 1 << 0;
    /// The encoder.
    pub const ENCODER: u8 = 1 << 1;
    /// Too hot.
    pub const TEMPERATURE: u8 = 1 << 2;
    /// Too much current.
    pub const CURRENT: u8 = 1 << 3;
    /// Load for too long: it holds with a fifth of its torque by itself.
    pub const OVERLOAD: u8 = 1 << 5;
}

/// No servo sets this bit: a reply that has it is damaged. Feetech's own clients refuse it too.
const NEVER: u8 = 1 << 7;

/// The reply of one servo.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Status<'a> {
    /// Whose reply.
    pub id: u8,
    /// What is wrong with it, see [`status_bit`].
    pub bits: u8,
    /// What was read.
    pub data: &'a [u8],
}

impl<'a> Status<'a> {
    /// The packet as a reply, if it can be one.
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
    /// [`EncodeError`] if it does not fit.
    pub fn encode(&self, out: &mut [u8]) -> Result<usize, EncodeError> {
        let mut frame = FrameWriter::new(out, self.id, self.bits);
        frame.extend(self.data);
        frame.finish()
    }

    /// Whether this is what servo `id` answers to a request for `len` bytes.
    pub fn answers(&self, id: u8, len: usize) -> bool {
        self.id == id && self.data.len() == len
    }
}
