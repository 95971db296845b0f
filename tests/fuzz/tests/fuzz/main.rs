//! Fuzz targets: each runs its corpus, then inputs that bolero finds.

#[cfg(feature = "bolero")]
mod firmware;
mod link;
mod readers;
mod servo_bus;
