//! The paper's evaluation: every motion, tracked by a rig (the figure at every scale) with every method of measuring
//! its state error, and how far off it was.
//!
//! - `setup` holds all that a run can vary; `controller` holds the core's settings, with bodies by name.
//! - `track` runs one clip with the core's tracker; `evaluation` runs all clips with all methods.
//! - `levers` computes the importance-weighted error; `metrics` and [`detail`] sum errors in a fixed order: by body, by
//!   size and over time, in bounded memory.
//! - `disturbance`, `friction` and `supply` add what the controller does not know of a rig.
//! - [`exercise`] makes motions of a user's rig; [`robustness`] varies rigs as built, and latencies.
//! - [`optimum`] finds the nearest poses by Newton's method in O(n), in f64 and without code of `core`; [`mod@pareto`]
//!   finds Pareto fronts.
//! - [`paper`] holds the paper's numbers; [`mod@report`] writes tables, JSON and CSV.
//! - [`mod@sweep`] runs grids of setups and resumes what was interrupted.

mod controller;
pub mod detail;
mod disturbance;
mod error;
mod evaluation;
pub mod exercise;
mod friction;
mod levers;
mod likeness;
mod metrics;
mod off;
pub mod optimum;
pub mod paper;
pub mod pareto;
mod reference;
pub mod report;
mod rig;
pub mod robustness;
mod setup;
mod supply;
pub mod sweep;
mod take;
#[cfg(test)]
mod tests;
mod track;

pub use sinew_core::tracker::MethodName;

pub use controller::{BodyName, ControllerSettings};
pub use detail::Detail;
pub use disturbance::Disturbance;
pub use error::{EvaluateError, RunError};
pub use evaluation::{
    ClipLength, Evaluation, FigureResult, MethodResult, Protocol, evaluate, run, steps_of_all,
};
pub use levers::Levers;
pub use likeness::{Angles, Likeness};
pub use metrics::{ErrorTotals, Errors, WeightedTotals};
pub use off::Off;
pub use rig::{CAPACITY, Rig};
pub use setup::{BodySource, RigTracker, Setup, SetupError};
pub use take::Take;
pub use take::numbers_of;
pub use track::{Step, step_count, track};
