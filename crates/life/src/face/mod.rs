//! Faces that other programs make, as motions of a rig's joints. The rig's `[[shape]]` tables connect both.
//!
//! - [`read`]: reads mouth cues of Rhubarb and Papagayo, and blend shapes of Live Link Face.
//! - [`Weights::of_cues`]: computes weights of visemes over time, with coarticulation.
//! - [`perform`]: computes joint positions from weights, within ranges and limits, and measures of each joint.

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
/// Maximum duration of a face, s.
const DURATION_MAX_S: f64 = 7200.0;
