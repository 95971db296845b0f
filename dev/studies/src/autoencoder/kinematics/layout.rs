//! Layout of the numbers of a joint, and protection from zero lengths.

/// Numbers per joint in the output of forward kinematics.
pub(in crate::autoencoder) const NUMBERS: usize = 9;

/// Added to squared lengths, so that a column without a length has a gradient.
pub(super) const SQUARE_MIN: f32 = 1e-12;
