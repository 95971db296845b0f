//! Turns live frames that arrive early, late, in any order, or not at all, into targets that move smoothly.

mod buffer;
mod coordinate;
mod timeline;

use core::fmt;

pub use buffer::{Following, LiveBuffer, LiveCounts, LiveTarget};
pub use coordinate::Coordinate;

/// Settings for following a live source.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LiveSettings {
    /// Time from the arrival of a frame without jitter to the tick that plays its pose, us: the jitter to be
    /// removed, plus the time between two frames.
    pub delay_us: u32,
    /// Time without a new frame after which the source is stale, us.
    pub stale_us: u32,
    /// Time between two steps of the caller, s.
    pub tick_s: f32,
}

impl LiveSettings {
    /// Settings for jitter of up to 100 ms, 60 frames per second with some loss, and a tick of 2 ms.
    pub const DEFAULT: Self = Self { delay_us: 150_000, stale_us: 200_000, tick_s: 0.002 };
}

/// An error in the setup of a live buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiveSetupError {
    /// The rig has more coordinates than the buffer has room for.
    Capacity {
        /// Number of coordinates that fit.
        room: usize,
        /// Number of coordinates of the rig.
        needs: usize,
    },
    /// The speed limit of this joint is not a positive number of at most 10⁶.
    Speed {
        /// Index of the joint in the list.
        joint: usize,
    },
    /// The tick is not a positive number of at most 1 s.
    Tick,
    /// The time-out is 0, or a time exceeds 2 s.
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

/// A reason for which a live frame, or a pose to start from, is not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum LiveRefusal {
    /// The number of coordinates is not the rig's.
    Count {
        /// Number of coordinates of the rig.
        rig: usize,
        /// Number of coordinates of the frame.
        frame: usize,
    },
    /// A number is NaN, infinite, or beyond 10⁶.
    Number {
        /// Index of the coordinate.
        coordinate: usize,
    },
    /// A quaternion is not of length 1.
    NotUnit {
        /// Index of the quaternion's first coordinate.
        coordinate: usize,
    },
    /// Frames for later times have already been played.
    TooLate,
    /// There is already a frame for that time.
    Twice,
    /// The frame's time differs by more than 1 s from the expected time.
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
