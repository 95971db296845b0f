//! Dynamics of a tree: inverse and forward dynamics, mass matrix, reflected inertia.

mod aba;
mod articulated_inertia;
mod body_axes;
mod crba;
pub(crate) mod least_constraint;
mod reflected;
mod resolved_acceleration;
mod rigid_inertia;
mod rnea;

pub use aba::{ArticulatedBody, forward_dynamics};
pub(crate) use articulated_inertia::ArticulatedInertia;
pub use crba::{CompositeBody, dof_count, mass_matrix};
pub use reflected::{OuterJoints, ReflectedInertia, reflected_inertia};
pub use resolved_acceleration::{ResolvedAccelerationScratch, resolved_acceleration};
pub use rnea::{BodyMotion, inverse_dynamics};
