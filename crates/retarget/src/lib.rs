//! Retargeting: which joint of a rig follows which of a performer, and the rig's pose nearest to the performance.
//!
//! Performer and rig are compared by [`Landmark`]s, which both have whatever their rest poses are.
//!
//! - [`rig::RigMatch`]: the joints of a rig, dealt out to landmarks by words and geometry.
//! - [`performer::Performer`]: what of a clip means the same on any rig.
//! - [`solve::bake`] and [`solve::Live`]: the rig's poses, for a whole clip or as it comes.
//! - [`mapping::Mapping`]: both sides' joints by names, as a text to edit.

#![forbid(unsafe_code)]

pub mod exchange;
pub mod feasibility;
mod landmark;
mod landmark_map;
pub mod mapping;
pub mod performer;
pub mod rig;
pub mod skeleton;
pub mod solve;

pub use landmark::{Landmark, Side};
pub use landmark_map::LandmarkMap;
