//! Exchange of a rig's motions with other programs.
//!
//! - [`table`]: writes a CSV of joint coordinates.
//! - [`keys`]: reads such a CSV, or keys at any times.
//! - [`clip`]: a clip of a skeleton, which `sinew_mocap::bvh` writes as BVH.
//! - [`blender`]: servo positions in the format of the Blender servo animation add-on.

pub mod blender;
pub mod clip;
mod columns;
pub mod keys;
pub mod servos;
pub mod table;
#[cfg(test)]
mod tests;
mod tied;

pub use columns::HeaderUnits;
