//! Motion capture: from a file, or the built-in generator, to the motion of the 18-body figure.
//!
//! One way only: a reader makes a [`Clip`]; gaps are filled, the clip is low-passed and resampled;
//! a skeleton mapping turns it into a [`FigureMotion`], which is all that the rest of the host sees.

pub mod builtin;
pub mod bvh;
pub mod clip;
pub mod filter;
pub mod gaps;
pub mod mapping;
pub mod motion;
pub mod pipeline;
pub mod resample;
pub mod tpose;

pub use clip::{Clip, GaplessClip, JointSample, Skeleton, SkeletonJoint};
pub use motion::FigureMotion;
pub use pipeline::{Error, Notice, Settings, load_paths, prepare};
