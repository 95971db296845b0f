//! The firmware inside a servo, which runs once in each of its ticks.
//!
//! Sources: ROBOTIS e-manual, pages of XL330, XL430, XM430 and MX; Feetech's memory tables. Behaviour that they do not
//! describe is guessed, and marked as a guess.

pub mod dynamixel;
pub mod feetech;
mod guard;
mod profile;
pub mod pulse;

pub use guard::Debounce;
pub use profile::Profile;

/// Measurements of a servo's own sensors.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensed {
    /// Encoder position over all turns since the simulation began, counts.
    pub position: i32,
    /// Speed from filtered differences of the position, counts/s.
    pub velocity: f64,
    /// Current of the motor, A.
    pub current_a: f64,
    /// Duty cycle at the motor, -1 to 1.
    pub duty: f64,
    /// Supply voltage, V.
    pub supply_v: f64,
    /// Temperature of the case, °C.
    pub case_c: f64,
    /// Current, as a part of the stall current at this supply voltage.
    pub load: f64,
}
