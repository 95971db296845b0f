//! Live frames that come early, late, in any order, or not at all, as targets that move smoothly.

mod buffer;
mod coordinate;
mod timeline;

use core::fmt;

pub use buffer::{Following, LiveBuffer, LiveCounts, LiveTarget};
pub use coordinate::Coordinate;

/// How a live source is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveSettings {
    /// How long after the fastest frame a pose is played, us: the jitter that is evened out, and a frame more.
    pub delay_us: u32,
    /// Without a new frame for so long, the source is stale, us.
    pub stale_us: u32,
    /// Time between two steps of the caller, s.
    pub tick_s: f32,
}

impl LiveSettings {
    /// For jitter of up to 100 ms and 60 frames a second, of which some are lost; a tick of 2 ms.
    pub const DEFAULT: Self = Self { delay_us: 150_000, stale_us: 200_000, tick_s: 0.002 };
}

/// Why a buffer cannot be made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiveSetupError {
    /// The rig has more numbers than there is room for.
    Capacity {
        /// How many there is room for.
        room: usize,
        /// How many the rig has.
        needs: usize,
    },
    /// The limit of speed of this joint is not a positive number of at most 10⁶.
    Speed {
        /// Which joint of the list.
        joint: usize,
    },
    /// The tick is not a positive number of at most 1 s.
    Tick,
    /// The time-out is 0, or a time is longer than 2 s.
    Time,
}

impl fmt::Display for LiveSetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capacity { room, needs } => {
                write!(f, "the rig has {needs} coordinates; the live buffer has room for {room}")
            }
            Self::Speed { joint } => {
                write!(
                    f,
                    "the largest speed of joint {joint} of the list is not a positive number of at most 1e6"
                )
            }
            Self::Tick => f.write_str("the tick is not a positive number of at most 1 s"),
            Self::Time => {
                f.write_str("delay and time-out are at most 2 s, and the time-out is not 0")
            }
        }
    }
}

impl core::error::Error for LiveSetupError {}

/// Why a live frame, or a pose to start from, is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiveRefusal {
    /// Another count of numbers than the rig's.
    Count {
        /// What the rig has.
        rig: usize,
        /// What came.
        frame: usize,
    },
    /// A number is NaN, infinite, or beyond 10⁶.
    Number {
        /// Which one.
        coordinate: usize,
    },
    /// A quaternion is not of length 1.
    NotUnit {
        /// Its first coordinate.
        coordinate: usize,
    },
    /// What it would be played with is over.
    TooLate,
    /// A frame of that time is there.
    Twice,
    /// Its time is more than 1 s off.
    Time,
}

impl fmt::Display for LiveRefusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { rig, frame } => {
                write!(f, "the frame has {frame} coordinates, the rig {rig}")
            }
            Self::Number { coordinate } => {
                write!(f, "coordinate {coordinate} of the frame is not a number of at most 1e6")
            }
            Self::NotUnit { coordinate } => {
                write!(f, "the quaternion at coordinate {coordinate} of the frame is not unit")
            }
            Self::TooLate => {
                f.write_str("the frame comes too late: give the buffer a longer delay")
            }
            Self::Twice => f.write_str("a frame of that time is there"),
            Self::Time => f.write_str("the frame's time is more than 1 s off that of the others"),
        }
    }
}

impl core::error::Error for LiveRefusal {}
