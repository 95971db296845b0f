//! Bytes that wait to be sent to the host.

use sinew_link::message::ToHost;
use sinew_link::{FRAME_MAX, encode};

/// Room for some of the longest frames, bytes.
const ROOM: usize = 4 * FRAME_MAX;

/// Frames that the line has not accepted yet.
#[derive(Debug)]
pub(super) struct Outbox {
    bytes: [u8; ROOM],
    begin: usize,
    end: usize,
}

impl Outbox {
    pub(super) const fn new() -> Self {
        Self { bytes: [0; ROOM], begin: 0, end: 0 }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.begin == self.end
    }

    /// Returns whether a frame of any length fits, and after it an answer of any length.
    pub(super) fn has_room(&self) -> bool {
        ROOM.saturating_sub(self.end) >= 2 * FRAME_MAX
    }

    /// Appends a message. A message that does not fit is lost, as on a line: the host asks again.
    pub(super) fn put(&mut self, message: &ToHost) {
        let room = self.bytes.get_mut(self.end..).unwrap_or_default();
        let len = encode(message, room).map_or(0, <[u8]>::len);
        self.end = self.end.saturating_add(len);
    }

    /// Passes bytes to the line, as many as it accepts.
    pub(super) fn send(&mut self, line: impl FnOnce(&[u8]) -> usize) {
        let waiting = self.bytes.get(self.begin..self.end).unwrap_or_default();
        if waiting.is_empty() {
            return;
        }
        self.begin = self.begin.saturating_add(line(waiting)).min(self.end);
        // If half of the buffer is sent, the rest moves to the front.
        if self.begin == self.end || self.begin > ROOM >> 1 {
            let len = self.end.saturating_sub(self.begin);
            for index in 0..len {
                let from = self.bytes.get(self.begin.saturating_add(index)).copied();
                if let (Some(to), Some(from)) = (self.bytes.get_mut(index), from) {
                    *to = from;
                }
            }
            (self.begin, self.end) = (0, len);
        }
    }
}
