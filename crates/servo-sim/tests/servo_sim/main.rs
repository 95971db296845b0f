//! Tests of simulated servos on simulated wires.

mod behaviour;
mod common;
mod drive_mode;
mod faults;
mod line;
mod port;
mod published;
mod rates;
mod registers;
mod rig;
mod sts3215;
