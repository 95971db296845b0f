//! The far end of a serial line: bytes of the firmware are stored with their time, bytes of the host are sent at
//! their time.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// Time after which a byte without a receiver is lost, ns: two bytes at 115,200 bit/s.
const PASSED_NS: u64 = 180_000;

/// A serial line to the host.
#[derive(Debug, Default)]
pub struct Wire {
    /// Bytes that the firmware has sent, and the time at which the last of them had left.
    pub sent: Vec<u8>,
    pub sent_ns: u64,
    /// Whether the transmitter's flag was cleared since then.
    pub is_flag_cleared: bool,
    /// Bytes of the host: start time and remaining bytes of each burst.
    to_say: VecDeque<(u64, VecDeque<u8>)>,
    /// Time at which the host sent its last byte.
    said_ns: u64,
    /// Number of the host's bytes that had no receiver.
    pub unheard: u64,
}

impl Wire {
    /// Sends bytes one after the other, the first not before `from_ns`.
    pub fn say(&mut self, from_ns: u64, bytes: Vec<u8>) {
        self.to_say.push_back((from_ns, bytes.into()));
    }

    /// Returns the start of the next burst that has not begun, or `None`.
    pub fn next_ns(&self, now_ns: u64) -> Option<u64> {
        self.to_say.iter().map(|(from_ns, _)| *from_ns).find(|from_ns| *from_ns > now_ns)
    }
}

impl Store for Wire {}

impl Peer for Wire {
    fn receive(&mut self, word: u16, at: &mut Timeline<'_, '_>) {
        self.sent.push(word.to_le_bytes()[0]);
        self.sent_ns = at.now().0;
    }

    fn transmit(&mut self, now: VirtualNanos) -> Option<u16> {
        loop {
            let (from_ns, bytes) = self.to_say.front_mut()?;
            if *from_ns > now.0 {
                return None;
            }
            let late_ns = now.0 - (*from_ns).max(self.said_ns);
            if late_ns > PASSED_NS || bytes.is_empty() {
                // The receiver was off while these bytes were sent.
                self.unheard += bytes.len() as u64;
                self.to_say.pop_front();
                continue;
            }
            // The next byte follows immediately.
            self.said_ns = now.0;
            return bytes.pop_front().map(u16::from);
        }
    }
}
