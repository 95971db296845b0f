//! Performances: clips of any skeleton, taken over by a rig, within its limits, and stored as shows.
//!
//! [`PreparedClip`] reads and cleans a clip; [`take_over`] puts it on a rig; [`RigClip`] is evaluated; [`Baker`]
//! stores it.

mod bake;
mod clip;
pub mod play;
pub mod rig;
mod rig_clip;
pub mod show;
mod table;
mod take_over;
pub mod teach;
pub mod words;

pub use bake::{BakeError, Baked, Baker, CHECK_HZ, Marks, Played, course, rig_hash};
pub use clip::{ClipError, ClipSettings, PreparedClip};
pub use rig_clip::RigClip;
pub use table::{feasibility, fitted, led};
pub use take_over::{TakeOverError, TakenOver, take_over};
