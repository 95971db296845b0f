//! Poles and margins of a joint with an elastic gear under the sampled loop of the tracker.
//!
//! A rotor turns a load through a spring with a damper; the encoder measures the load. In every tick the encoder is
//! read, the observer estimates and predicts, and the torque for the requested acceleration is held during a later
//! tick. The model is linear: it has no friction except viscous friction, no limits and no encoder steps.
//! [`FlexibleJoint::with_play`] describes how play is included.
//!
//! - `plant`: the joint, and its exact step over a time in which the torque is held.
//! - `control`: the loop, and matrices of the whole loop.
//! - `margins`: stability margins of the loop.
//! - `matrix`, `complex`: mathematics of the other files.

mod complex;
mod control;
mod margins;
mod matrix;
mod plant;
#[cfg(test)]
mod tests;

pub use control::ControlLoop;
pub use margins::{Margins, Stability};
pub use plant::FlexibleJoint;
