//! A servo as physics, without its program.

mod gear;
mod heat;
mod motor;
mod parameters;

pub use gear::{Flow, Gear};
pub use heat::Heat;
pub use motor::{Draw, Motor, Power};
pub use parameters::{Parameters, ParametersError};
