//! Retargeting: matches the joints of a rig with those of a performer, and finds the rig's pose that is nearest to
//! the performance.
//!
//! Performer and rig are compared by [`Landmark`]s, which do not depend on their rest poses.
//!
//! - [`rig::RigMatch`]: assigns the joints of a rig to landmarks, by words and geometry.
//! - [`performer::Performer`]: measures those properties of a clip that any rig can follow.
//! - [`solve::bake`] and [`solve::Live`]: compute the rig's poses, for a whole clip or frame by frame.
//! - [`mapping::Mapping`]: assigns joints of a clip to joints of a rig by name, as a text to edit.
//!
//! # Files
//! In the order in which a clip is processed:
//! - `landmark`, `landmark_map`: the 18 places that performer and rig have in common.
//! - `skeleton/`: matches the joints of a recorded skeleton with landmarks, with confidence and reason; finds its
//!   unit and up axis.
//! - `rig/`: finds the landmarks of a rig, by words (`text`, `chains`) and by geometry (`groups`, `points`,
//!   `hinge`, `mirror`).
//! - `performer/`: directions, twists and postures of a clip.
//! - `mapping/`: mappings from a clip's joint names to a rig's: proposed, written, read, resolved; also curves from
//!   joint to joint.
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
