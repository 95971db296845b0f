//! Tests of simulated servos on simulated wires.

mod behaviour;
mod common;
mod faults;
mod line;
mod port;
mod published;
mod rates;
mod rig;
