//! Performances: clips of any skeleton, taken over by a rig, within its limits, and stored as shows.
//!
//! [`PreparedClip`] reads and cleans a clip; [`take_over`] puts it on a rig; [`RigClip`] is evaluated; [`Baker`]
//! stores it.
//!
//! - [`rig`] loads rigs of the user, reviews them, and computes torques for rows of a table.
//! - `clip` reads and cleans a clip, `take_over` puts it on a rig, `bake` makes a show, `table` reports on it.
//! - [`play`] plays a show on simulated servos: `parts` and `line` hold what controller and lines are made of, `stand`
//!   runs a tick, `director` commands it. `play/board` is a whole node with flash in a file.
//! - [`teach`] lets a hand lead a rig: `leads` is the hand's way, `lesson` the simulated rig, `taught` the motion that
//!   is left.

mod bake;
mod clip;
pub mod play;
pub mod rig;
mod rig_clip;
mod table;
mod take_over;
pub mod teach;
pub mod text;

pub use bake::{BakeError, Baked, Baker, CHECK_HZ, Marks, Played, course, rig_hash};
pub use clip::{ClipError, ClipSettings, PreparedClip};
pub use rig_clip::RigClip;
pub use table::{feasibility, fitted, led};
pub use take_over::{TakeOverError, TakenOver, take_over};
