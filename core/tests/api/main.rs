//! The crate as its users meet it: the first example, the README, dynamics in coordinates, and settings and states that
//! are stored.

mod dynamics;
mod first_torque;
mod readme;
#[cfg(feature = "serde")]
mod serde;
