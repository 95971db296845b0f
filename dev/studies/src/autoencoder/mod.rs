//! D. Holden, *Joint Error Propagation* (2025): weights for a loss on local rotations.
//!
//! An auto-encoder of poses is trained in five ways that differ only in the loss. It is judged by the joint positions
//! and rotations that it reconstructs for subjects that are not in the training data.

mod adamw;
mod anatomy;
mod checkpoint;
mod data;
mod errors;
mod kinematics;
mod loss;
mod method;
mod network;
mod report;
mod run;
mod samples;
mod timing;
mod training;
mod two_columns;
mod weights;

pub use anatomy::Group;
pub use checkpoint::CheckpointError;
pub use data::Poses;
pub use errors::{Errors, Means, distance_cm};
pub use kinematics::Form;
pub use method::Method;
pub use report::{json, tables};
pub use run::{Error, Example, Outcome, Plan, Study, run};
pub use timing::{StepTime, time_steps};
pub use training::Schedule;
pub use weights::WeightsError;
