//! Messages between host and node: the length in four bytes, little-endian, then the message in postcard.
//!
//! ```text
//! host  PowerOn Line.. Servo..     Below      Tick          Plan, PlanMore  Said          Over
//! node                             Stepped    Exchange      Planned         IsComplete    Ticked
//! ```
//! The host begins. The node answers every message except those of the set-up ([`ToNode::PowerOn`],
//! [`ToNode::Line`] and [`ToNode::Servo`]) and [`ToNode::Panic`]. A tick of a node without a rig ends at once. In a
//! node with a rig, lines may run in parallel: the host asks for the packets of each line at its time.

use serde::{Deserialize, Serialize};

use crate::built_in::{BuiltIn, BusLine, Servo};

/// Room for the longest message, bytes.
const ROOM: usize = 4096;

/// A message to the node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ToNode<'a> {
    /// The first power-on, with blank flash, and the built-in parts.
    PowerOn(BuiltIn),
    /// A line of a [rig](BuiltIn::Rig).
    Line(BusLine),
    /// A servo of a rig.
    Servo(Servo),
    /// A tick of the loop.
    Tick {
        /// Start of the tick, µs.
        now_us: u64,
        /// Whether the loop of the emergency stop is open.
        is_stopped: bool,
    },
    /// Asks for the first packets of a line in this tick.
    Plan {
        /// Index of the line.
        line: usize,
    },
    /// Bytes that servos have sent.
    Said {
        /// Index of the line.
        line: usize,
        /// The received bytes.
        bytes: &'a [u8],
    },
    /// Asks for more packets of a line.
    PlanMore {
        /// Index of the line.
        line: usize,
        /// Remaining time of the tick, µs.
        left_us: u32,
    },
    /// The lines have no more packets in this tick.
    Over {
        /// Time at which the last line finished, µs.
        now_us: u64,
    },
    /// Runs steps of the background task.
    Below {
        /// Time of the steps, µs.
        now_us: u64,
        /// Number of steps.
        steps: u32,
        /// Bytes that wait on the host link, at most [`LINE_AT_ONCE`](crate::limits::LINE_AT_ONCE).
        line: &'a [u8],
    },
    /// Orders a panic of the program. The image then resets its board, keeps its flash, and waits for
    /// [`ToNode::PowerOn`] again.
    Panic,
}

/// A message from the node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToHost<'a> {
    /// The commands of a tick are ready: the lines may start.
    Exchange,
    /// Bytes for servos, and the time for their answers; `None` if there is nothing to send.
    Planned(#[serde(borrow)] Option<Packets<'a>>),
    /// Whether all answers are complete.
    IsComplete(bool),
    /// The tick is over, with its result; `None` if there is no rig.
    Ticked(#[serde(borrow)] Option<LoopMessage<'a>>),
    /// The steps of the background task are done.
    Stepped {
        /// Number of bytes that were read from the link.
        taken: usize,
        /// Bytes for the link.
        line: &'a [u8],
        /// Whether the node restarts, with its present flash.
        restarts: bool,
    },
}

/// Packets for servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Packets<'a> {
    /// The bytes of the packets.
    pub bytes: &'a [u8],
    /// Length of the answers without byte stuffing.
    pub reply_len: usize,
    /// Time for packets and answers, µs.
    pub time_us: u32,
}

/// Result of the loop in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopMessage<'a> {
    /// Whether the tick was complete: the watchdog was fed.
    pub is_fed: bool,
    /// Whether servos get their signals (OE).
    pub outputs: bool,
    /// Number of the state.
    pub state: u8,
    /// Faults whose condition is present, and faults that wait to be cleared: a [bit](crate::node::bit) for each.
    pub faults: [u32; 2],
    /// The [commanded](crate::node::commanded) values.
    pub commanded: &'a [u8],
}

/// A byte channel to the other end.
///
/// **Duty**: both functions return when all bytes are transferred, or with the reason why they never will be.
pub trait Bytes {
    /// Reason why bytes cannot be transferred.
    type Error;

    /// Fills `bytes` with bytes from the other end.
    ///
    /// # Errors
    /// The other end is gone.
    fn read(&mut self, bytes: &mut [u8]) -> Result<(), Self::Error>;

    /// Sends bytes to the other end.
    ///
    /// # Errors
    /// The other end is gone.
    fn write(&mut self, bytes: &[u8]) -> Result<(), Self::Error>;
}

/// Error of a missing or invalid message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeError<E> {
    /// The bytes cannot be read.
    Bytes(E),
    /// The bytes are not a valid message: the other end has another version.
    Message,
}

/// One end of a message channel.
#[derive(Debug)]
pub struct End<B> {
    /// The byte channel that carries the messages.
    pub bytes: B,
    room: [u8; ROOM],
}

impl<B: Bytes> End<B> {
    /// Creates an end on a byte channel.
    pub fn new(bytes: B) -> Self {
        Self { bytes, room: [0; ROOM] }
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The other end is gone.
    ///
    /// # Panics
    /// If the message is longer than the room for the longest message.
    pub fn put(&mut self, message: &impl Serialize) -> Result<(), B::Error> {
        let (head, body) = self.room.split_first_chunk_mut().expect("there is room for a length");
        let len = postcard::to_slice(message, body).expect("messages have room").len();
        *head = u32::to_le_bytes(u32::try_from(len).expect("it is below the room"));
        self.bytes.write(&self.room[..head_len() + len])
    }

    /// Receives the next message.
    ///
    /// # Errors
    /// [`TakeError`] if the bytes cannot be read, or are not a message.
    pub fn take<'a, M: Deserialize<'a>>(&'a mut self) -> Result<M, TakeError<B::Error>> {
        let mut head = [0; head_len()];
        self.bytes.read(&mut head).map_err(TakeError::Bytes)?;
        let len = usize::try_from(u32::from_le_bytes(head)).map_err(|_| TakeError::Message)?;
        let body = self.room.get_mut(..len).ok_or(TakeError::Message)?;
        self.bytes.read(body).map_err(TakeError::Bytes)?;
        postcard::from_bytes(body).map_err(|_| TakeError::Message)
    }
}

const fn head_len() -> usize {
    size_of::<u32>()
}
