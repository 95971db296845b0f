//! Blends one clip into another at their nearest poses, along geodesics.
//!
//! The frames in the middle of the blend are found exactly: they are the pair with the shortest geodesic of all pairs
//! of frames ([`nearest`]). During the blend both clips play. Every pose is on the geodesic between the two clips'
//! poses at that time, at a smoothly increasing share of its length ([`blend`]).

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
