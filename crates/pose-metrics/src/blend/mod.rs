//! A transition from one clip to another where their poses are nearest, the blend along geodesics.
//!
//! The places are found exactly: of all pairs of frames, the one whose geodesic is shortest ([`nearest`]). In the
//! blend both clips play, and every pose lies on the geodesic between theirs of that moment, a smooth share of the
//! way from one to the other ([`blend`]).

mod nearest;
mod pair;
mod table;
mod transition;

pub use nearest::{FrameRanges, Nearest, nearest};
pub use pair::{Pair, PairError};
pub use table::{Outcome, Side, json, text};
pub use transition::{Blend, PeakSpeed, blend};

pub use transition::least_jerk;

#[cfg(test)]
mod tests;
