//! The paper's evaluation: a rig (the figure at every scale) tracks every motion with every method of measuring
//! its state error, and the tracking errors are measured.
//!
//! - `setup` contains all settings of a run; `controller` contains the core's settings, with bodies by name.
//! - `run` tracks one motion with the core's tracker, step by `step`; `together` tracks many, with their exact plants
//!   and their `trackers` in the lanes of vector instructions; `evaluation` tracks all motions with all methods.
//! - `importance_weights` computes the importance-weighted error; `metrics` and [`detail`] sum errors in a fixed
//!   order: by body, by size and over time, in bounded memory.
//! - `disturbance` describes differences between a rig and the controller's model; `sensors`, `drives` (with
//!   `friction`) and `supply` implement them.
//! - `motion` defines a motion that can be tracked; [`exercise`] makes motions of a user's rig.
//! - `trial` tracks all motions with one setup; [`robustness`] repeats that on many rigs with random errors,
//!   [`latency`] with increasing latency of torques.
//! - [`optimum`] finds the nearest poses by Newton's method in O(n), in f64 and without code of `core`;
//!   [`mod@pareto`] finds Pareto fronts.
//! - [`paper`] contains the paper's numbers; [`mod@report`] writes tables, JSON and CSV.
//! - [`mod@sweep`] runs grids of setups and resumes interrupted sweeps.

mod capacity;
mod controller;
pub mod detail;
mod disturbance;
mod drives;
mod error;
mod evaluation;
pub mod exercise;
mod friction;
mod importance_weights;
pub mod latency;
mod likeness;
mod metrics;
mod motion;
pub mod optimum;
pub mod paper;
pub mod pareto;
mod pose_error;
mod reference;
pub mod report;
mod rig;
pub mod robustness;
mod run;
mod sensors;
mod setup;
mod step;
mod supply;
pub mod sweep;
#[cfg(test)]
mod tests;
mod together;
mod trackers;
mod trial;

pub use sinew_core::tracker::MethodName;

pub use capacity::{CAPACITY, MAX_LATENCY_STEPS};
pub use controller::{BodyName, ControllerSettings};
pub use detail::Detail;
pub use disturbance::Disturbance;
pub use error::{EvaluateError, RunError, SetupError};
pub use evaluation::{
    ClipLength, Evaluation, FigureResult, MethodResult, Protocol, count_all_steps, evaluate,
};
pub use importance_weights::ImportanceWeights;
pub use likeness::{Angles, Likeness};
pub use metrics::{ErrorTotals, Errors, WeightedTotals};
pub use motion::{EvaluatedMotion, count_steps, visit_numbers};
pub use pose_error::PoseError;
pub use rig::Rig;
pub use run::Run;
pub use setup::{BodySource, RigTracker, Setup};
pub use step::Step;
pub use trial::{Lost, TRACKS_BELOW_DEG, Trial, run_trial};
