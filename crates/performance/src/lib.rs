//! Performances: clips of any skeleton that are retargeted to a rig, kept within its limits, and stored as shows.
//!
//! [`PreparedClip`] reads and cleans a clip; [`retarget_clip`] retargets it to a rig; [`RigClip`] is evaluated;
//! [`Baker`] stores it; [`RigPerformance`] does all these steps for a clip.
//!
//! - [`rig`] loads the user's rigs, reviews them, and computes torques for rows of a table.
//! - `clip` reads and cleans a clip, `propose` proposes its mapping to a rig, `retargeted_clip` retargets it,
//!   `own_motion` reads a motion of the rig's own joints, `layers` applies other motions to such a motion, `bake` makes
//!   a show of a motion, `rig_performance` fits a motion and bakes it, `left` compares a motion before and after a fit,
//!   `rounding` separates excesses of ranges from the rounding of a show, `table` reports on a motion, `likeness`
//!   compares it with the performer.
//! - [`following`] predicts how far servos by position stay behind a show.
//! - [`play`] plays a show on simulated servos: `rig_parts` and `line` contain the parts of controller and bus
//!   lines, `simulated_rig` runs a tick, `director` commands it. `play/board` is a whole node with its flash in a file.
//! - [`teach`] makes a motion from a rig that is led by hand: `guide_trajectory` is the hand's path, `session` the
//!   simulated rig, `result` the recorded motion.

mod bake;
mod clip;
pub mod following;
mod layers;
mod left;
mod likeness;
mod own_motion;
pub mod play;
mod propose;
mod retargeted_clip;
pub mod rig;
mod rig_clip;
mod rig_performance;
mod rounding;
mod table;
pub mod teach;
pub mod text;

pub use bake::{BakeError, Baked, Baker, CHECK_HZ, ShowMarks, ShowPlayback, course, rig_hash};
pub use clip::{ClipError, ClipSettings, PreparedClip};
pub use layers::{LayerChoice, LayerMode, LayeredMotion};
pub use left::JointLeft;
pub use likeness::Likeness;
pub use own_motion::OwnMotion;
pub use propose::propose_mapping;
pub use retargeted_clip::{RetargetError, RetargetedClip, retarget_clip};
pub use rig_clip::RigClip;
pub use rig_performance::{MotionChoices, RigPerformance, ShowChoices, read_mapping};
pub use table::{feasibility, led};
