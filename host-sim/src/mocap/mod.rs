//! Motion capture: from a file, or the built-in generator, to the motion of the 18-body figure.
//!
//! One way only: a reader makes a [`Recording`], in the file's units, which becomes a [`Clip`]; gaps are filled,
//! joint flips reported, the clip is low-passed and resampled; a skeleton mapping turns it into a [`FigureMotion`],
//! which is all that the rest of the host sees.

pub mod asf_amc;
pub mod builtin;
pub mod bvh;
pub mod clip;
pub mod deepmimic;
pub mod filter;
pub mod flips;
pub mod format;
pub mod gaps;
pub mod mapping;
pub mod motion;
pub mod pipeline;
pub mod recording;
pub mod resample;
pub mod text;
pub mod tpose;

pub use clip::{Clip, GaplessClip, JointSample, Skeleton, SkeletonJoint};
pub use motion::FigureMotion;
pub use pipeline::{Error, Notice, Settings, load_paths, prepare};
pub use recording::Recording;
