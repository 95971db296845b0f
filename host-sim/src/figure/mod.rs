//! The 18-body figure of the paper: its bodies, and what they weigh.

pub mod body;
#[cfg(test)]
pub(crate) mod fixture;
pub mod model;
mod segments;
pub mod solids;

pub use body::{BODIES, BODY_COUNT, Body, is_leaf};
pub use model::{BodyModel, BodyModelError, MassProperties};
