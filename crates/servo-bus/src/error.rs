//! Errors of encoding packets, of commands and of setups.

use core::fmt;

/// The reason why a packet was not written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum EncodeError {
    /// The buffer is too small.
    Room {
        /// Size of the buffer in bytes.
        has: usize,
    },
    /// The packet is longer than its length field allows.
    Length,
    /// No servo can have this id, or the instruction cannot be broadcast.
    Id(u8),
    /// The write is dangerous (EEPROM lock, factory reset, calibration): use the function with this name instead.
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

/// The reason why a command was refused. The servo keeps its last command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum CommandError {
    /// No servo has this index.
    Servo {
        /// The index that was given.
        index: usize,
        /// Number of servos on the bus.
        count: usize,
    },
    /// The number is NaN or infinite.
    NotFinite(&'static str),
    /// The servo does not support this command in its mode.
    Unsupported(&'static str),
}

impl fmt::Display for CommandError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Servo { index, count } => {
                write!(f, "there is no servo {index}; the bus has {count}, from 0")
            }
            Self::NotFinite(what) => write!(f, "the {what} is not a finite number"),
            Self::Unsupported(what) => write!(f, "the servo accepts no {what} in its mode"),
        }
    }
}

impl core::error::Error for CommandError {}

/// The reason why a setup of servos on a bus was refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum SetupError {
    /// There are more servos than the bus has room for.
    Capacity {
        /// Maximum number of servos.
        holds: usize,
    },
    /// No servo can have this id or channel.
    Id(u8),
    /// Two servos have the same id or channel.
    Shared(u8),
    /// The value of this setting is invalid.
    Setting {
        /// Id or channel of the servo.
        id: u8,
        /// Name of the setting.
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
                write!(f, "servo {id}: {what} is not a valid number")
            }
        }
    }
}

impl core::error::Error for SetupError {}
