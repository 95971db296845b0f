//! A joint with a soft gear under the sampled loop of the tracker: its poles and its margins.
//!
//! A rotor turns a load through a spring with a damper; the encoder sits at the load. Every tick the encoder is read,
//! the observer estimates and looks ahead, and the torque for the wanted acceleration is held over a later tick. All of
//! it is linear: no friction but viscous, no limits, no steps of the encoder. [`FlexibleJoint::with_play`] says how
//! play enters.
//!
//! - `plant`: the joint, and its exact step over a time in which the torque is held.
//! - `control`: the loop, and the whole of it as matrices.
//! - `margins`: how much it bears before it swings by itself.
//! - `matrix`, `complex`: what they compute with.

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
