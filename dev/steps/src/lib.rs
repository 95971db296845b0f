//! Parts that `xtask` and `sinew-measure` share: programs run as timed steps, compilers for boards, paths of images.
//!
//! - [`step`] runs programs and reports their time; [`arm`] chooses the compiler for boards; [`image`] has the paths
//!   of images.

#![forbid(unsafe_code)]

pub mod arm;
pub mod image;
pub mod step;
