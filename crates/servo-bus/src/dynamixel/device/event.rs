//! Events of a simulated servo.

/// An event that the simulation of a servo may want to know.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// Items were written.
    Written {
        /// First address.
        address: u16,
        /// How many bytes.
        length: u16,
    },
    /// It starts anew: torque is off, RAM is as after power-up.
    Rebooted,
    /// It is as it left the factory, and starts anew.
    FactoryReset,
    /// It forgot full turns: its position is within one now.
    TurnsCleared,
    /// No instruction came for as long as the bus watchdog allows.
    WatchdogRanOut,
}
