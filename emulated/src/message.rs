//! What host and node say to each other: the length in four bytes, little-endian, then the message by postcard.
//!
//! The host begins. Behind [`ToNode::PowerOn`] each [`ToNode::Tick`] is answered by [`ToHost::Ticked`]. Between the two
//! the node may ask for any number of [exchanges](ToHost::Exchange) on its bus, each of which goes on with
//! [`ToNode::Said`], answered by [`ToHost::IsComplete`], until [`ToNode::Over`].

use serde::{Deserialize, Serialize};

use crate::arm::Kind;

/// Room for the longest message.
const ROOM: usize = 4096;

/// Bytes of the host's line that may come in a tick.
pub const LINE_AT_ONCE: usize = 1024;

/// What the node is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToNode<'a> {
    /// Its first power-on, with blank flash: what it moves.
    PowerOn(Kind),
    /// A tick.
    Tick {
        /// When it begins, and when it ends, µs.
        from_to_us: [u64; 2],
        /// Whether the loop of the emergency stop is open.
        is_stopped: bool,
        /// Steps below the loop.
        steps: u32,
        /// What waits on the line, at most [`LINE_AT_ONCE`] bytes.
        line: &'a [u8],
    },
    /// What servos have said.
    Said(&'a [u8]),
    /// The exchange is over.
    Over {
        /// Its end, µs.
        now_us: u64,
        /// What is left of the tick, µs.
        left_us: u32,
    },
}

/// What the node says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToHost<'a> {
    /// Bytes for servos, and for how long they may answer.
    Exchange {
        /// The bytes.
        bytes: &'a [u8],
        /// The time, µs.
        wait_us: u32,
    },
    /// Whether the answers are all there.
    IsComplete(bool),
    /// The tick is over.
    Ticked {
        /// What came of the loop; none if there is no rig.
        #[serde(borrow)]
        of_loop: Option<OfLoop<'a>>,
        /// Bytes that it took from the line.
        taken: usize,
        /// Bytes for the line.
        line: &'a [u8],
        /// It begins anew, with the flash that it has.
        restarts: bool,
    },
}

/// What came of the loop in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct OfLoop<'a> {
    /// Whether the tick was whole: the watchdog was fed.
    pub is_fed: bool,
    /// Whether servos have their signals (OE).
    pub outputs: bool,
    /// The number of its state.
    pub state: u8,
    /// What it has [commanded](crate::node::commanded).
    pub commanded: &'a [u8],
}

/// Bytes to the other end and from it.
///
/// **Duty**: both come back when all bytes are through, or not at all.
pub trait Bytes {
    /// Fills `bytes` with what the other end has sent.
    fn read(&mut self, bytes: &mut [u8]);

    /// Sends bytes to the other end.
    fn write(&mut self, bytes: &[u8]);
}

/// One end, for messages.
#[derive(Debug)]
pub struct End<B> {
    bytes: B,
    room: [u8; ROOM],
}

impl<B: Bytes> End<B> {
    /// An end of a line of bytes.
    pub fn new(bytes: B) -> Self {
        Self { bytes, room: [0; ROOM] }
    }

    /// Sends a message.
    ///
    /// # Panics
    /// If it is longer than the longest.
    pub fn put(&mut self, message: &impl Serialize) {
        let (head, body) = self.room.split_first_chunk_mut().expect("there is room for a length");
        let len = postcard::to_slice(message, body).expect("messages have room").len();
        *head = u32::to_le_bytes(u32::try_from(len).expect("it is below the room"));
        self.bytes.write(&self.room[..head_len() + len]);
    }

    /// The next message.
    ///
    /// # Panics
    /// If it is none.
    pub fn take<'a, M: Deserialize<'a>>(&'a mut self) -> M {
        let mut head = [0; head_len()];
        self.bytes.read(&mut head);
        let len = usize::try_from(u32::from_le_bytes(head)).expect("32 bits");
        let body = self.room.get_mut(..len).expect("messages have room");
        self.bytes.read(body);
        postcard::from_bytes(body).expect("the other end is of the same version")
    }
}

const fn head_len() -> usize {
    size_of::<u32>()
}
