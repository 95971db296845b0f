//! Rotations as the first two columns of their matrices: six numbers without a discontinuity (Zhou et al., *On the
//! Continuity of Rotation Representations in Neural Networks*, 2019).

use glam::{DMat3, DQuat, DVec3};

/// Numbers of a rotation in this form.
pub(super) const NUMBERS: usize = 6;

/// Returns the first two columns, one after the other.
pub(super) fn from_rotation(rotation: DQuat) -> [f64; NUMBERS] {
    let [x, y, _] = DMat3::from_quat(rotation).to_cols_array_2d();
    [x[0], x[1], x[2], y[0], y[1], y[2]]
}

/// Returns the rotation of two columns that need not be unit or perpendicular: the first keeps its direction
/// (Gram-Schmidt).
pub(super) fn to_rotation(columns: [f64; NUMBERS]) -> DQuat {
    let [ax, ay, az, bx, by, bz] = columns;
    let x = DVec3::new(ax, ay, az).normalize_or(DVec3::X);
    let b = DVec3::new(bx, by, bz);
    let y = (b - x * x.dot(b)).normalize_or(x.any_orthonormal_vector());
    DQuat::from_mat3(&DMat3::from_cols(x, y, x.cross(y)))
}

#[cfg(test)]
mod tests {
    use sinew_host_util::random::{Random, Subject};

    use super::*;

    #[test]
    fn there_and_back() {
        let mut random = Random::new(3, Subject::Noise);
        for _ in 0..200 {
            let (axis, angle) = (random.normal3(), random.between(-4.0, 4.0));
            let rotation = DQuat::from_axis_angle(axis.normalize(), angle);
            let back = to_rotation(from_rotation(rotation));
            assert!(back.dot(rotation).abs() > 1.0 - 1e-12, "{rotation} {back}");
        }
    }

    #[test]
    fn lengths_and_a_lean_do_not_matter() {
        let [ax, ay, az, bx, by, bz] = from_rotation(DQuat::from_rotation_z(0.7));
        let leant = [3.0 * ax, 3.0 * ay, 3.0 * az, bx + ax, by + ay, bz + az];
        let angle = to_rotation(leant).angle_between(DQuat::from_rotation_z(0.7));
        assert!(angle < 1e-7, "{angle}");
        assert!(to_rotation([0.0; 6]).is_normalized());
    }
}
