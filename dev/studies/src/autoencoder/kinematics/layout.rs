//! How the numbers of a joint are laid out, and kept from a zero length.

/// Numbers per joint that forward kinematics makes.
pub(in crate::autoencoder) const NUMBERS: usize = 9;

/// Added to squared lengths, so that a column without a length has a gradient.
pub(super) const SQUARE_MIN: f32 = 1e-12;
