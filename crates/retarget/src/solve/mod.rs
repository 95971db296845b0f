//! Finds the rig's poses that are nearest to a performance, frame by frame, within ranges and speeds.
//!
//! Directions and twists of limbs are compared, and orientations of pelvis, chest, head and feet; rest poses are
//! never compared, and positions only for root, feet, and the hand of a rig that is one arm. Each sweep is a
//! Gauss-Newton step in joint coordinates, whose bounds are respected within the step (an active set), not applied
//! afterwards.

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
pub(crate) use banded::Banded;
pub use limb::{BakedLimb, Hand};
pub use live::{Live, NotFinite};
pub use settings::{Limb, Settings};
pub use solver::{ActiveBound, Bound};
pub use tilt::best_tilt;
