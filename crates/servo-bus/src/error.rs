//! Why something cannot be written, commanded or set up.

use core::fmt;

/// Why a packet cannot be written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small.
    Room {
        /// How many bytes it has.
        has: usize,
    },
    /// The packet would be longer than its length field can say.
    Length,
    /// No servo can have this id, or the instruction cannot be broadcast.
    Id(u8),
    /// Writes what would harm: EEPROM lock, factory reset, calibration. There is a call for it by name.
    OnlyByName(&'static str),
}

impl fmt::Display for EncodeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Room { has } => {
                write!(f, "the packet does not fit in {has} bytes; give a larger buffer")
            }
            Self::Length => {
                f.write_str("the packet is longer than the protocol allows; use several packets")
            }
            Self::Id(id) => write!(f, "no packet of this kind can go to id {id}"),
            Self::OnlyByName(what) => write!(f, "{what} is written only by the call of that name"),
        }
    }
}

impl core::error::Error for EncodeError {}

/// Why a command is refused. The servo keeps its last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CommandError {
    /// There is no servo of this index.
    Servo {
        /// The index.
        index: usize,
        /// How many servos there are.
        count: usize,
    },
    /// The number is NaN or infinite.
    NotFinite(&'static str),
    /// The servo cannot do this, or its mode is another one.
    Unsupported(&'static str),
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Servo { index, count } => {
                write!(f, "there is no servo {index}; the bus has {count}, from 0")
            }
            Self::NotFinite(what) => write!(f, "the {what} is not a finite number"),
            Self::Unsupported(what) => write!(f, "the servo takes no {what} in its mode"),
        }
    }
}

impl core::error::Error for CommandError {}

/// Why servos cannot share a bus as they are described.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SetupError {
    /// More servos than there is room for.
    Capacity {
        /// How many there is room for.
        holds: usize,
    },
    /// No servo can have this id or channel.
    Id(u8),
    /// Two servos have this id or channel.
    Shared(u8),
    /// The number of this setting cannot be.
    Setting {
        /// Id or channel of the servo.
        id: u8,
        /// The setting.
        what: &'static str,
    },
}

impl fmt::Display for SetupError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Capacity { holds } => {
                write!(f, "there are more servos than the {holds} that this bus holds")
            }
            Self::Id(id) => write!(f, "no servo can have id {id}"),
            Self::Shared(id) => write!(f, "two servos have id {id}; each needs its own"),
            Self::Setting { id, what } => {
                write!(f, "servo {id}: {what} is not a number that can be")
            }
        }
    }
}

impl core::error::Error for SetupError {}
