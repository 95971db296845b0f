//! Retargeting: which joint of a rig follows which of a performer, and the rig's pose nearest to the performance.
//!
//! Performer and rig are compared by [`Landmark`]s, which both have whatever their rest poses are.
//!
//! - [`rig::RigMatch`]: the joints of a rig, dealt out to landmarks by words and geometry.
//! - [`performer::Performer`]: what of a clip means the same on any rig.
//! - [`solve::bake`] and [`solve::Live`]: the rig's poses, for a whole clip or as it comes.
//! - [`mapping::Mapping`]: both sides' joints by names, as a text to edit.
//!
//! # Files
//! Along the way of a clip:
//! - `landmark`, `landmark_map`: the 18 places that performer and rig have in common.
//! - `skeleton/`: which joint of a recorded skeleton is which landmark, how sure, and why; its unit and its up.
//! - `rig/`: the landmarks of a rig, by words (`text`, `chains`) and by geometry (`groups`, `points`, `hinge`,
//!   `mirror`).
//! - `performer/`: directions, twists and postures of a clip.
//! - `mapping/`: both sides by names: proposed, written, read, resolved; curves from joint to joint.
//! - `solve/`: `terms` and their `aim`, one bounded step (`solver`, `normal`), the first pose (`first`, `branch`),
//!   contacts and paths over a clip (`contact`, `path`); a whole clip (`bake`) or frame by frame (`live`).
//! - `feasibility/`: limits, where a motion exceeds them (`check`), the nearest motion within them (`fit`), loops.
//! - `exchange/`: motions as CSV, as BVH's skeleton, as servo positions, as JSON of Blender's add-on.

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
