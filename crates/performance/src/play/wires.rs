//! Counts and hashes the bytes on the wires.

/// Offset basis and prime of FNV-1a with 64 bits.
const FNV: (u64, u64) = (0xcbf2_9ce4_8422_2325, 0x0100_0000_01b3);

/// Traffic on all lines.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Wires {
    /// Number of bytes that the controller sent.
    pub sent: u64,
    /// Number of bytes that servos answered.
    pub answered: u64,
    /// FNV-1a of all bytes, in their order.
    pub hash: u64,
}

impl Default for Wires {
    fn default() -> Self {
        Self { sent: 0, answered: 0, hash: FNV.0 }
    }
}

impl Wires {
    pub(super) fn sent(&mut self, bytes: &[u8]) {
        self.sent += bytes.len() as u64;
        self.note(bytes);
    }

    pub(super) fn answered(&mut self, bytes: &[u8]) {
        self.answered += bytes.len() as u64;
        self.note(bytes);
    }

    fn note(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.hash = (self.hash ^ u64::from(*byte)).wrapping_mul(FNV.1);
        }
    }
}
