//! Dynamics of the tree.

mod reflected;
mod rnea;

pub use reflected::{OuterJoints, ReflectedInertia, reflected_inertia};
pub use rnea::{BodyMotion, inverse_dynamics};
