//! The host side of Sinew: mocap in, simulated figure, the paper's tables out.

pub mod figure;
pub mod mocap;
pub mod verify;
