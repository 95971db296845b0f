//! Tests of the controller with simulated servos in process: a performance, every fault in every state, and random
//! input.

#![expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "the controller's side is f32, the servos' f64"
)]

mod anything;
mod arming;
pub(crate) mod cell;
mod dead;
mod jump;
mod matrix;
mod play;
mod pulses;
mod registers;
mod run_in;
pub(crate) mod swing;
pub(crate) mod test_rig;
mod torque_stuck;
mod winding;
