//! Motions of a rig as other programs take them, and back.
//!
//! - [`table`]: a CSV of joint coordinates.
//! - [`clip`]: a clip of a skeleton, which `sinew_mocap::bvh` writes as BVH.
//! - [`blender`]: positions of servos, as the Blender servo animation add-on writes them.

pub mod blender;
pub mod clip;
pub mod servos;
pub mod table;
#[cfg(test)]
mod tests;
