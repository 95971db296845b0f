//! Motions without a performer.
//!
//! - [`sound`]: a jaw that follows the loudness of a sound.
//! - [`face`]: motions of faces that other programs make from a sound or a camera.
//! - [`idle`]: a long loop of breathing, blinking, glances and weight shifts.
//!
//! `limit` reduces a motion until it keeps a joint's limits of speed and acceleration.

pub mod face;
pub mod idle;
mod limit;
pub mod sound;
