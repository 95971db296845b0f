//! One fault as it is kept.

use super::Fault;
use crate::supervisor::State;

/// A fault that came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct FaultRecord {
    /// Which.
    pub fault: Fault,
    /// The state in which it came.
    pub state: State,
    /// The servo that it is of.
    pub servo: Option<u16>,
    /// The board's start in which it came, counted.
    pub start: u32,
    /// When it came first, µs after that start.
    pub time_us: u64,
    /// How often it came, up to 65,535.
    pub times: u16,
}

impl FaultRecord {
    /// Whether it is the same but for time and times.
    pub(crate) fn is_as(&self, other: &Self) -> bool {
        let same = (self.fault, self.state, self.servo, self.start);
        same == (other.fault, other.state, other.servo, other.start)
    }
}
