//! The 18-body figure of the paper: its bodies, their motion and their masses.
//!
//! - `body`, `motion` and `dimensions` describe the 18 bodies, how they move, and how they are scaled.
//! - [`mapping`] maps recorded skeletons to the figure: known skeletons, or a proposal for an unknown skeleton.
//! - `de_leva` and [`hanavan`] compute mass properties: by regressions, or from the solids of a measured subject
//!   (`subjects/`). `placement` places both on a skeleton by the same rules.
//! - [`plant`] simulates a mechanism through one trait: `articulated` is exact and is the reference for `rapier`,
//!   whose settings are data with a reason for each.
//! - [`angles_rad`] computes the angles of many rotations in vector instructions.
//! - [`builtin`] makes the built-in clips: a synthetic fighter, generated from seeds and recorded with noise and gaps.
//! - [`measured`] decides the size and the up axis of a clip or a character. No other module decides them.
//! - [`pipeline`] prepares files: skip, remove impossible samples, fill gaps, find flips, low-pass at the recorded
//!   rate, resample, map to the figure.

mod angles;
pub mod body;
pub mod builtin;
mod cut;
mod de_leva;
mod dimensions;
mod error;
#[doc(hidden)]
pub mod fixture;
pub mod hanavan;
mod landmark;
pub mod mapping;
pub mod measured;
pub mod model;
mod motion;
pub mod pipeline;
mod placement;
pub mod plant;
pub mod solids;

pub use angles::angles_rad;
pub use body::{BODIES, BODY_COUNT, Body, Root, is_leaf};
pub use de_leva::mass_fraction as de_leva_mass_fraction;
pub use dimensions::Dimensions;
pub use error::BodyModelError;
pub use hanavan::Subject;
pub use landmark::limb_landmark;
pub use mapping::Mapping;
pub use model::BodyModel;
pub use motion::FigureMotion;
