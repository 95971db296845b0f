//! Fault reports, with the fault numbers of `docs/faults.md`.

use serde::{Deserialize, Serialize};

use super::State;

/// A recorded fault: the data that the firmware's supervisor keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultRecord {
    /// Number of the fault in `docs/faults.md`, which never changes.
    pub fault: u8,
    /// State in which the fault occurred.
    pub state: State,
    /// Index of the affected servo.
    pub servo: Option<u16>,
    /// Count of the board's starts at the time of the fault.
    pub start: u32,
    /// Time of the first occurrence, us after that start.
    pub time_us: u64,
    /// Number of occurrences, up to 65,535.
    pub times: u16,
}

impl FaultRecord {
    /// Returns `true` if the fault is a warning, which does not stop the rig.
    pub const fn is_warning(&self) -> bool {
        self.fault >= 64
    }
}

/// A record of the log of faults, with the number of records in the log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FaultReport {
    /// Number of records in the log.
    pub count: u16,
    /// The requested record; `None` beyond the last.
    pub record: Option<FaultRecord>,
}
