//! S. Hauberg & K. S. Pedersen, "Spatial measures between human poses for classification and understanding" (2012).

pub mod components;
pub mod geodesic_ratio;
pub mod isomap;
pub mod mann_whitney;
pub mod mds;
pub mod medoid_shift;
pub mod sample;
