//! Exchange of a rig's motions with other programs.
//!
//! - [`table`]: a CSV of joint coordinates.
//! - [`clip`]: a clip of a skeleton, which `sinew_mocap::bvh` writes as BVH.
//! - [`blender`]: servo positions in the format of the Blender servo animation add-on.

pub mod blender;
pub mod clip;
pub mod servos;
pub mod table;
#[cfg(test)]
mod tests;
