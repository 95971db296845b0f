//! Dynamics of the tree.

pub(crate) mod least_constraint;
mod reflected;
mod resolved_acceleration;
mod rnea;
mod spatial_inertia;

pub use reflected::{OuterJoints, ReflectedInertia, reflected_inertia};
pub use resolved_acceleration::{Resolved, resolved_acceleration};
pub use rnea::{BodyMotion, inverse_dynamics};
pub(crate) use spatial_inertia::SpatialInertia;
