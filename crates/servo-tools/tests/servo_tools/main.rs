//! Tools for servos, with simulated ones.

mod common;
mod ended;
mod port;
mod rigs;
mod servos;
mod tap;
