//! Motions without a performer.
//!
//! - [`sound`]: a jaw that follows the loudness of a sound.
//! - [`idle`]: a long loop of breathing, blinking, glances and weight shifts.

pub mod idle;
pub mod sound;
