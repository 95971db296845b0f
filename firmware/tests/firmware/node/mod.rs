//! Tests of a whole node with simulated servos and flash, and a host on a bad line, in process.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the controller's side is f32, the servos' f64"
)]

#[path = "../../../../crates/storage/tests/storage/common/flash.rs"]
mod flash;

mod corpus;
mod decoders;
mod emulated;
mod first_fault;
mod full_line;
mod hardware;
mod host;
mod hostile;
mod hour;
mod ideal;
mod inputs;
mod line;
mod live;
mod matrix;
mod mismatch;
mod page;
mod pass;
mod people;
mod power_cut;
mod registers;
mod settings;
mod shows;
mod silence;
mod stored;
mod stranger;
mod told;
mod whole;
mod world;

use crate::controller::{cell, swing, test_rig};
