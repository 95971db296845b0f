//! What host and node say to each other: the length in four bytes, little-endian, then the message by postcard.
//!
//! ```text
//! host  PowerOn Line.. Servo..     Below      Tick          Plan, PlanMore  Said          Over
//! node                             Stepped    Exchange      Planned         IsComplete    Ticked
//! ```
//! The host begins, and each of its messages from [`ToNode::Tick`] and [`ToNode::Below`] on is answered. A tick of a
//! node without a rig is over at once. In one with a rig lines may talk side by side: the host asks for what goes over
//! each of them, when it is its time.

use serde::{Deserialize, Serialize};

use crate::built_in::{BuiltIn, BusLine, Servo};

/// Room for the longest message.
const ROOM: usize = 4096;

/// What the node is told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum ToNode<'a> {
    /// Its first power-on, with blank flash: what it has built in.
    PowerOn(BuiltIn),
    /// A line of a [rig](BuiltIn::Rig).
    Line(BusLine),
    /// A servo of a rig.
    Servo(Servo),
    /// A tick of the loop.
    Tick {
        /// When it begins, µs.
        now_us: u64,
        /// Whether the loop of the emergency stop is open.
        is_stopped: bool,
    },
    /// What goes over a line first in this tick?
    Plan {
        /// The line.
        line: usize,
    },
    /// What servos have said.
    Said {
        /// On this line.
        line: usize,
        /// The bytes.
        bytes: &'a [u8],
    },
    /// What else goes over a line?
    PlanMore {
        /// The line.
        line: usize,
        /// What is left of the tick, µs.
        left_us: u32,
    },
    /// No line wants anything more.
    Over {
        /// When that was, µs.
        now_us: u64,
    },
    /// Steps below the loop.
    Below {
        /// When they are made, µs.
        now_us: u64,
        /// How many.
        steps: u32,
        /// The bytes that wait on the line of the link, at most [`LINE_AT_ONCE`](crate::limits::LINE_AT_ONCE) bytes.
        line: &'a [u8],
    },
    /// The program stops itself, by a panic. The image resets its board then, with its flash as it is, and asks for
    /// [`ToNode::PowerOn`] again.
    Panic,
}

/// What the node says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum ToHost<'a> {
    /// Commands of a tick are there: the lines may talk.
    Exchange,
    /// Bytes for servos, and for how long they may answer; none if there is nothing to say.
    Planned(#[serde(borrow)] Option<Packets<'a>>),
    /// Whether the answers are all there.
    IsComplete(bool),
    /// The tick is over: what came of it; none if there is no rig.
    Ticked(#[serde(borrow)] Option<LoopMessage<'a>>),
    /// The steps below the loop are made.
    Stepped {
        /// Bytes that it took from the line.
        taken: usize,
        /// Bytes for the line.
        line: &'a [u8],
        /// It begins anew, with the flash that it has.
        restarts: bool,
    },
}

/// Bytes for servos.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Packets<'a> {
    /// The bytes.
    pub bytes: &'a [u8],
    /// How many come back, without stuffing.
    pub reply_len: usize,
    /// How long all of it takes, µs.
    pub time_us: u32,
}

/// What came of the loop in a tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct LoopMessage<'a> {
    /// Whether the tick was whole: the watchdog was fed.
    pub is_fed: bool,
    /// Whether servos have their signals (OE).
    pub outputs: bool,
    /// The number of its state.
    pub state: u8,
    /// Faults whose condition is there, and those that wait to be cleared: a [bit](crate::node::bit) for each.
    pub faults: [u32; 2],
    /// What it has [commanded](crate::node::commanded).
    pub commanded: &'a [u8],
}

/// Bytes to the other end and from it.
///
/// **Duty**: both come back when all bytes are through, or say why they never will be.
pub trait Bytes {
    /// Why they are not through.
    type Error;

    /// Fills `bytes` with what the other end has sent.
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

/// Why there is no next message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TakeError<E> {
    /// Bytes do not come.
    Bytes(E),
    /// They are no message: the other end is of another version.
    Message,
}

/// One end, for messages.
#[derive(Debug)]
pub struct End<B> {
    /// What carries them.
    pub bytes: B,
    room: [u8; ROOM],
}

impl<B: Bytes> End<B> {
    /// An end of a line of bytes.
    pub fn new(bytes: B) -> Self {
        Self { bytes, room: [0; ROOM] }
    }

    /// Sends a message.
    ///
    /// # Errors
    /// The other end is gone.
    ///
    /// # Panics
    /// If it is longer than the longest.
    pub fn put(&mut self, message: &impl Serialize) -> Result<(), B::Error> {
        let (head, body) = self.room.split_first_chunk_mut().expect("there is room for a length");
        let len = postcard::to_slice(message, body).expect("messages have room").len();
        *head = u32::to_le_bytes(u32::try_from(len).expect("it is below the room"));
        self.bytes.write(&self.room[..head_len() + len])
    }

    /// The next message.
    ///
    /// # Errors
    /// [`TakeError`].
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
