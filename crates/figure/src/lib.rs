//! The 18-body figure of the paper: its bodies, how they move and what they weigh.
//!
//! - `body`, `motion` and `dimensions` describe the 18 bodies, how they move, and how they are scaled.
//! - [`mapping`] maps recorded skeletons on the figure: known skeletons, or a proposal for an unknown one.
//! - `de_leva` and [`hanavan`] compute mass properties: by regressions, or from the solids of a measured subject
//!   (`subjects/`). `placement` lays both on a skeleton by the same rules.
//! - [`plant`] simulates a mechanism behind one trait: `articulated` is exact and judges `rapier`, whose settings are
//!   data with a reason for each.
//! - [`builtin`] makes the built-in clips: a seeded fighter, recorded with noise and gaps.
//! - [`measured`] decides how large a clip or a character is and which way is up. It is the only place that decides it.
//! - [`pipeline`] prepares files: skip, fill gaps, find flips, low-pass at the recorded rate, resample, map on the
//!   figure.

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

pub use body::{BODIES, BODY_COUNT, Body, Root, is_leaf};
pub use de_leva::mass_fraction as de_leva_mass_fraction;
pub use dimensions::Dimensions;
pub use error::BodyModelError;
pub use hanavan::Subject;
pub use landmark::limb_landmark;
pub use mapping::Mapping;
pub use model::BodyModel;
pub use motion::FigureMotion;
