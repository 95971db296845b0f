//! The far end of a serial line: what the firmware sends is kept with its time, what the host gives is said at its
//! time.

use std::collections::VecDeque;

use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// A byte that nobody listened to for so long has passed, ns: two at 115,200 bit/s.
const PASSED_NS: u64 = 180_000;

/// A line to the host.
#[derive(Debug, Default)]
pub struct Wire {
    /// What the firmware has sent, and when the last of it had left.
    pub sent: Vec<u8>,
    pub sent_ns: u64,
    /// Whether the transmitter's flag was cleared since then.
    pub is_flag_cleared: bool,
    /// What the host says: from when, and what of it is left.
    to_say: VecDeque<(u64, VecDeque<u8>)>,
    /// When it said a byte last.
    said_ns: u64,
    /// Bytes of the host that nobody listened to.
    pub unheard: u64,
}

impl Wire {
    /// Says bytes one behind the other, the first from `from_ns` on.
    pub fn say(&mut self, from_ns: u64, bytes: Vec<u8>) {
        self.to_say.push_back((from_ns, bytes.into()));
    }

    /// When the next burst begins that has not begun.
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
                // It was said to a receiver that was off.
                self.unheard += bytes.len() as u64;
                self.to_say.pop_front();
                continue;
            }
            // The next one comes right behind it.
            self.said_ns = now.0;
            return bytes.pop_front().map(u16::from);
        }
    }
}
