//! The paper's evaluation: every motion, tracked by a rig (the figure at every scale) with every method of measuring
//! its state error, and how far off it was.

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
