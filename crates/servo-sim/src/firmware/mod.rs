//! What the program inside a servo does, once in each of its ticks.
//!
//! Sources: ROBOTIS e-manual, pages of XL330, XL430, XM430 and MX; Feetech's memory tables. What they leave open is a
//! guess, and says so where it stands.

pub mod dynamixel;
pub mod feetech;
mod guard;
mod profile;
pub mod pulse;

pub use guard::Debounce;
pub use profile::Profile;

/// What a servo knows of itself.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Sensed {
    /// Of the encoder, over all turns since the simulation began, counts.
    pub position: i32,
    /// By differences of it, filtered, counts/s.
    pub velocity: f64,
    /// A.
    pub current_a: f64,
    /// Part of the supply at the motor, -1 to 1.
    pub duty: f64,
    /// V.
    pub supply_v: f64,
    /// °C.
    pub case_c: f64,
    /// Current over what the motor would draw at standstill and this supply.
    pub load: f64,
}
