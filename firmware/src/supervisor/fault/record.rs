//! A fault as it is stored in the log.

use super::Fault;
use crate::supervisor::State;

/// Record of a fault that occurred.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultRecord {
    /// The fault.
    pub fault: Fault,
    /// State in which the fault occurred.
    pub state: State,
    /// Index of the servo with the fault, if it belongs to one.
    pub servo: Option<u16>,
    /// Number of the board's start in which the fault occurred.
    pub start: u32,
    /// Time of its first occurrence after that start, µs.
    pub time_us: u64,
    /// Number of occurrences, up to 65,535.
    pub times: u16,
}

impl FaultRecord {
    /// Returns whether two records differ at most in time and number of occurrences.
    pub(crate) fn is_as(&self, other: &Self) -> bool {
        let same = (self.fault, self.state, self.servo, self.start);
        same == (other.fault, other.state, other.servo, other.start)
    }
}
