//! Events of a simulated servo.

/// An event that the simulation of a servo may want to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A controller wrote registers.
    Written {
        /// First address that was written.
        address: u16,
        /// Number of bytes that were written.
        length: u16,
    },
    /// The servo restarted: torque is off, and RAM holds its power-up values.
    Rebooted,
    /// The servo returned to its factory settings and restarted.
    FactoryReset,
    /// The servo cleared its full turns: its position is now within one turn.
    TurnsCleared,
    /// No instruction arrived within the time of the bus watchdog.
    WatchdogRanOut,
}
