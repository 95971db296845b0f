//! The physics of a servo, without its firmware.

mod gear;
mod heat;
mod motor;
mod parameters;

pub use gear::{Flow, Gear};
pub use heat::Heat;
pub use motor::{Draw, Motor, Power};
pub use parameters::{Parameters, ParametersError};
