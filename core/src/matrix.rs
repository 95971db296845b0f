//! Small matrices that glam does not have.

use glam::{Mat3, Vec3};

/// Returns the outer product `a bᵀ`.
pub(crate) fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// Returns the matrix of the cross product `v ×`.
pub(crate) fn cross_matrix(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}
