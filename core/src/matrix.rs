//! Small matrices that glam does not have.

use glam::{Mat3, Vec3};

/// `a bᵀ`.
pub(crate) fn outer(a: Vec3, b: Vec3) -> Mat3 {
    Mat3::from_cols(a * b.x, a * b.y, a * b.z)
}

/// The matrix of `v ×`.
pub(crate) fn cross_matrix(v: Vec3) -> Mat3 {
    Mat3::from_cols(Vec3::new(0.0, v.z, -v.y), Vec3::new(-v.z, 0.0, v.x), Vec3::new(v.y, -v.x, 0.0))
}

/// Inverse of a symmetric positive definite matrix, by its cofactors; zero if it is not definite, and no numbers if its
/// determinant is too large for f32: that must not look like a body that nothing moves.
pub(crate) fn symmetric_inverse(m: &Mat3) -> Mat3 {
    let (xx, xy, xz) = (m.x_axis.x, m.x_axis.y, m.x_axis.z);
    let (yy, yz, zz) = (m.y_axis.y, m.y_axis.z, m.z_axis.z);
    let (c_xx, c_xy, c_xz) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let determinant = xx * c_xx + xy * c_xy + xz * c_xz;
    let share = if determinant > f32::MAX {
        f32::NAN
    } else if determinant > 0.0 {
        1.0 / determinant
    } else {
        0.0
    };
    let (c_yz, c_xy, c_xz) = ((xy * xz - xx * yz) * share, c_xy * share, c_xz * share);
    Mat3::from_cols(
        Vec3::new(c_xx * share, c_xy, c_xz),
        Vec3::new(c_xy, (xx * zz - xz * xz) * share, c_yz),
        Vec3::new(c_xz, c_yz, (xx * yy - xy * xy) * share),
    )
}
