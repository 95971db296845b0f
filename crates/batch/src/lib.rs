//! The core's inverse dynamics of many instants at once, its trackers of several rigs and its distances of many poses,
//! for fits, checks, evaluations and searches on a PC.
//!
//! Each instant, rig or pose gets the operations of the core in the core's order, and nothing fuses multiply and add.
//! The results are therefore equal to those of the core bit by bit, whatever vector instructions compute them.
//!
//! - [`Batch`] computes efforts; `joint` computes the motions of joints, `sweep` those of bodies and their wrenches.
//! - [`Trackers`] computes the torques of several rigs that follow performances.
//! - [`PoseSequence`] computes distances of a pose to many poses.
//! - `lanes`: vectors, matrices and states of all instants or rigs; `turn`: maps of rotations.
//! - [`widest`]: the processor's widest vector instructions, chosen while the program runs.

#![deny(missing_docs)]
#![expect(clippy::inline_always, reason = "see `Work::run`")]
#![expect(clippy::needless_range_loop, reason = "loops over lanes become vector instructions")]

mod distance;
mod efforts;
mod joint;
mod lanes;
mod sweep;
#[cfg(test)]
mod tests;
mod tracker;
mod turn;
mod widest;

pub use distance::PoseSequence;
pub use efforts::{Batch, LANES};
pub use tracker::{TRACKER_LANES, Trackers};
pub use widest::{Work, widest};
