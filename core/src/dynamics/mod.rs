//! Dynamics of the tree.

mod rnea;

pub use rnea::{BodyMotion, inverse_dynamics};
