//! Faces of other programs as motions of a rig's joints, by the `[[shape]]` tables of rig.toml.
//!
//! - [`read`]: mouth cues of Rhubarb and Papagayo, and blend shapes of Live Link Face.
//! - [`Weights::of_cues`]: weights of visemes over time, with coarticulation.
//! - [`perform`]: weights to joints, within ranges and limits, with measures.

mod coarticulation;
mod error;
mod json;
mod kind;
mod live_link;
mod moho;
mod names;
mod nnls;
mod performer;
mod poses;
#[cfg(test)]
mod tests;
mod track;
mod tsv;

pub use error::FaceError;
pub use kind::read;
pub use performer::{FaceMotion, JointMeasure, perform};
pub use track::{Cue, FaceTrack, Weights};

/// Rate of the motion, Hz.
pub const RATE_HZ: f64 = 100.0;
/// The longest face, s.
const DURATION_MAX_S: f64 = 7200.0;
