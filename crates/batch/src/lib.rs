//! The core's inverse dynamics of many instants at once, for fits, checks and other work on a PC.
//!
//! Each instant gets the operations of the core in the core's order, and nothing fuses multiply and add. The results
//! are therefore equal to those of the core bit by bit, whatever vector instructions compute them.
//!
//! - [`Batch`] computes efforts; `joint` computes the motions of joints, `sweep` those of bodies and their wrenches.
//! - `lanes`: vectors and matrices of all instants.
//! - [`widest`]: the processor's widest vector instructions, chosen while the program runs.

#![deny(missing_docs)]
#![expect(clippy::inline_always, reason = "see `Work::run`")]
#![expect(clippy::needless_range_loop, reason = "loops over lanes become vector instructions")]

mod efforts;
mod joint;
mod lanes;
mod sweep;
#[cfg(test)]
mod tests;
mod widest;

pub use efforts::Batch;
pub use lanes::LANES;
pub use widest::{Work, widest};
