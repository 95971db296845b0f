//! A whole node with simulated servos and flash, and a host on a bad line, in process.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the controller's side is f32, the servos' f64"
)]

#[path = "../controller/cell.rs"]
mod cell;
#[path = "../../../crates/storage/tests/common/flash.rs"]
mod flash;
#[path = "../controller/stand.rs"]
#[expect(dead_code, reason = "other tests use the rest")]
mod stand;
#[path = "../controller/swing.rs"]
mod swing;

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
mod pass;
mod people;
mod power_cut;
mod registers;
mod settings;
mod shows;
mod silence;
mod stored;
mod told;
mod whole;
mod world;
