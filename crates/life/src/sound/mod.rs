//! A jaw that follows the loudness of a sound.
//!
//! - [`levels()`]: the loudness of a WAV file over time.
//! - [`envelope()`]: the opening of a mouth, from 0 to 1.
//! - [`Jaw`]: the angle of a jaw, within its limits.

mod envelope;
mod jaw;
#[cfg(test)]
mod tests;
mod wav;

pub use envelope::{EnvelopeSettings, envelope};
pub use jaw::{Jaw, JawError, JawMotion};
pub use wav::{Levels, SoundError, duration_s, levels};

/// Rate of levels, openings and angles, Hz.
pub const RATE_HZ: f64 = 200.0;
