//! Tools for servos, with simulated ones.

mod common;
mod port;
mod rigs;
mod servos;
mod tap;
