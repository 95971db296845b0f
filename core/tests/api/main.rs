//! Tests of the crate's public interface: the first example, the README, dynamics in coordinates, and stored settings
//! and states.

mod dynamics;
mod first_torque;
mod readme;
#[cfg(feature = "serde")]
mod serde;
