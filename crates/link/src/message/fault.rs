//! Faults as they are told, by their numbers in `docs/faults.md`.

use serde::{Deserialize, Serialize};

use super::State;

/// A fault that came: what the firmware's supervisor records of it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Its number in `docs/faults.md`, which never changes.
    pub fault: u8,
    /// The state in which it came.
    pub state: State,
    /// The servo that it is of.
    pub servo: Option<u16>,
    /// The board's start in which it came, counted.
    pub start: u32,
    /// When it came first, us after that start.
    pub time_us: u64,
    /// How often it came, up to 65,535.
    pub times: u16,
}

impl FaultRecord {
    /// Whether it is a warning: no rig is stopped by it.
    pub const fn is_warning(&self) -> bool {
        self.fault >= 64
    }
}

/// A fault of the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultReport {
    /// How many the log holds.
    pub count: u16,
    /// The one that was asked for; none beyond the last.
    pub record: Option<FaultRecord>,
}
