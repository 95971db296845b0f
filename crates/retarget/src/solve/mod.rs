//! The rig's own pose nearest to a performance, frame by frame, within ranges and speeds.
//!
//! Directions of limbs, their twist, and how pelvis, chest, head and feet stand are compared, never rest poses; points
//! only of the root and of feet. Each sweep is a Gauss-Newton step in joint coordinates whose bounds are kept inside
//! the step (an active set), not cut afterwards.

mod aim;
mod bake;
mod banded;
mod branch;
mod contact;
mod first;
mod limb;
mod live;
mod model;
mod normal;
mod path;
mod performance;
mod settings;
mod solver;
mod terms;
mod tilt;

pub use bake::{Baked, bake};
pub use limb::BakedLimb;
pub use live::{Live, NotFinite};
pub use settings::{Limb, Settings};
pub use solver::{ActiveBound, Bound};
pub use tilt::best_tilt;
