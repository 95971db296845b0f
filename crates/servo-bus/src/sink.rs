//! Writes bytes into a caller's buffer.

use crate::EncodeError;

/// A writer that appends bytes to a buffer. It remembers an overflow, so that one check at the end is enough.
pub(crate) struct Sink<'a> {
    buffer: &'a mut [u8],
    len: usize,
    full: bool,
}

impl<'a> Sink<'a> {
    pub(crate) fn new(buffer: &'a mut [u8]) -> Self {
        Self { buffer, len: 0, full: false }
    }

    pub(crate) fn push(&mut self, byte: u8) {
        match self.buffer.get_mut(self.len) {
            Some(slot) => {
                *slot = byte;
                self.len = self.len.saturating_add(1);
            }
            None => self.full = true,
        }
    }

    pub(crate) fn extend(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.push(*byte);
        }
    }

    /// Replaces a byte that was already written.
    pub(crate) fn set(&mut self, index: usize, byte: u8) {
        if let Some(slot) = self.buffer.get_mut(index) {
            *slot = byte;
        }
    }

    pub(crate) fn written(&self) -> &[u8] {
        self.buffer.get(..self.len).unwrap_or_default()
    }

    /// Returns the number of bytes written, or an error if there was too little room.
    pub(crate) fn finish(&self) -> Result<usize, EncodeError> {
        if self.full { Err(EncodeError::Room { has: self.buffer.len() }) } else { Ok(self.len) }
    }
}
