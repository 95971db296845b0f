//! Motion capture: reads files, and returns clean motions of their own skeletons.
//!
//! There are two kinds of motion:
//! - A [`Recording`] is the result of a reader: lengths are in the file's unit, samples may be missing, and the
//!   rate is unknown in some formats.
//! - A [`Clip`] is in metres and seconds, with a sample of every joint in every frame. [`gaps::fill`] creates it
//!   from a recording; [`filter`], [`flips`], [`resample`](mod@resample) and [`bvh::write`] process it.
//!
//! World and joint frames are those of the file. Positions have the suffix `_m` for metres; in a recording they are in
//! the file's unit until [`Recording::in_metres`].
//!
//! ```no_run
//! use sinew_mocap::{bvh, filter::LowPass, format, gaps, resample::resample};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! // BVH has no unit of length. These files are in centimetres.
//! let recording = format::read("walk.bvh".as_ref())?.in_metres(0.01);
//! let frame_time_s = recording.frame_time_s.ok_or("the file does not state its rate")?;
//! // Gaps of up to half a second are filled.
//! let (mut clip, filled) = gaps::fill(recording, frame_time_s, 0.5)?;
//! println!("{filled}");
//! if let Some(low_pass) = LowPass::new(clip.rate_hz(), 6.0) {
//!     low_pass.apply_to_clip(&mut clip)?;
//! }
//! bvh::write("walk-50hz.bvh".as_ref(), &resample(&clip, 50.0), 0.01)?;
//! # Ok(())
//! # }
//! ```
//!
//! A [`SkeletonMap`] defines the bodies of another figure by a skeleton's joints.
//!
//! # Files
//! - `bvh/`, `asf_amc/`, `deepmimic/`, `format`: a reader for each format, and the choice of the reader.
//! - `recording`, `clip`, `skeleton`: the two kinds of motion; skeletons and their forward kinematics.
//! - `read`, `encoding`, `text`, `damage`, `kind`: whole files, their text, implausible data, kinds of files.
//! - `placed`: rotations of joints, computed from positions.
//! - `up`, `gaps`, `flips`, `filter`, `resample`: the steps of cleaning.
//! - `files`: the clips in a list of files and folders.
//! - `skeleton_map`: definition of a figure's bodies by joints, as data.

pub mod asf_amc;
pub mod bvh;
mod clip;
pub mod damage;
pub mod deepmimic;
pub mod encoding;
pub mod files;
pub mod filter;
pub mod flips;
pub mod format;
pub mod gaps;
mod kind;
mod placed;
pub mod read;
mod recording;
pub mod resample;
mod skeleton;
pub mod skeleton_map;
pub mod text;
mod up;

pub use clip::{Clip, moving_root};
pub use kind::Kind;
pub use recording::Recording;
pub use skeleton::{JointSample, Skeleton, SkeletonJoint, forward_kinematics};
pub use skeleton_map::SkeletonMap;
pub use up::{Up, axis_name, to_y};
