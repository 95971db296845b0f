//! S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and understanding" (2012).

pub mod classes;
pub mod classify;
pub mod cluster;
pub mod components;
pub mod cost;
mod distances;
pub mod geodesic_ratio;
pub mod isomap;
pub mod mann_whitney;
pub mod mds;
pub mod medoid_shift;
pub mod sample;
mod sign_test;
mod summary;
mod tables;

pub use distances::{Spread, WrittenDistances, write_distances};
pub use summary::Summary;
