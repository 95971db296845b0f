//! Tests of the servo tools with simulated servos.

mod common;
mod ended;
mod port;
mod rigs;
mod servos;
mod tap;
