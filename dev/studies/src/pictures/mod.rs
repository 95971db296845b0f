//! Pictures of the studies, made of the parts of the report.

mod autoencoder;
mod classify;
mod cluster;
mod spatial;

pub use autoencoder::write_study;
pub use classify::write_classify;
pub use cluster::write_cluster;
pub use spatial::{write_geodesic_ratio, write_mds};
