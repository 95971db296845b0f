//! Motion capture: from a file, or the built-in generator, to the motion of the 18-body figure.
//!
//! One way only: a reader makes a [`Clip`]; gaps are filled, the clip is low-passed and resampled;
//! a skeleton mapping turns it into a [`FigureMotion`], which is all that the rest of the host sees.

pub mod builtin;
pub mod clip;
pub mod motion;

pub use clip::{Clip, JointSample, Skeleton, SkeletonJoint};
pub use motion::FigureMotion;
