//! Dynamics of the tree.

pub(crate) mod least_constraint;
mod reflected;
mod rnea;
mod spatial_inertia;

pub use reflected::{OuterJoints, ReflectedInertia, reflected_inertia};
pub use rnea::{BodyMotion, inverse_dynamics};
pub(crate) use spatial_inertia::SpatialInertia;
