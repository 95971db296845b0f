//! Straight lines between poses, in several coordinates, for comparison with geodesics.

use core::f64::consts::{FRAC_PI_2, TAU};

use glam::{DQuat, DVec3, EulerRot};

/// Coordinates of a ball joint in which a straight line is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Line {
    /// Rotation vectors: the geodesic line of the measures, [`sinew_pose_metrics::spatial::Metric::Line`].
    RotationVectors,
    /// Unit quaternions: every joint takes its own shortest path.
    GreatArcs,
    /// Euler angles about z, y and x, as in the files.
    EulerAngles,
}

impl Line {
    /// Returns the rotation at a share `t` of the line between two rotations.
    pub(super) fn between(self, from: DQuat, to: DQuat, t: f64) -> DQuat {
        match self {
            Self::RotationVectors => {
                let (start, step) = shortest(vector(from), vector(to));
                DQuat::from_scaled_axis(start + step * t)
            }
            Self::GreatArcs => from.slerp(to, t).normalize(),
            Self::EulerAngles => {
                let [a, b] = [from, to].map(|turn| DVec3::from(turn.to_euler(EulerRot::ZYX)));
                let step = (b - a).map(|angle| angle - TAU * libm::rint(angle / TAU));
                let DVec3 { x, y, z } = a + step * t;
                DQuat::from_euler(EulerRot::ZYX, x, y, z)
            }
        }
    }
}

/// Returns a rotation vector of at most half a turn.
fn vector(rotation: DQuat) -> DVec3 {
    (if rotation.w < 0.0 { -rotation } else { rotation }).to_scaled_axis()
}

/// Returns start and step of the shortest line between the vectors of two rotations. Each rotation except the identity
/// has a second vector, with the opposite direction.
fn shortest(from: DVec3, to: DVec3) -> (DVec3, DVec3) {
    let direct = (from, to - from);
    if from.length().max(to.length()) < FRAC_PI_2 {
        return direct;
    }
    let other = |vector: DVec3| {
        let angle = vector.length();
        if angle > 0.0 { vector * ((angle - TAU) / angle) } else { vector }
    };
    let ways = [(other(from), to - other(from)), (from, other(to) - from)];
    ways.into_iter().fold(direct, |best, way| {
        if way.1.length_squared() < best.1.length_squared() { way } else { best }
    })
}

#[cfg(test)]
mod tests {
    use core::f64::consts::PI;

    use super::*;

    #[test]
    fn every_line_goes_from_one_end_to_the_other() {
        let ends = [
            DVec3::new(0.3, -0.2, 0.9),
            DVec3::new(-2.0, 1.9, 0.4),
            DVec3::new(2.1, -1.8, -0.9),
            DVec3::ZERO,
        ];
        let ends = ends.map(DQuat::from_scaled_axis);
        for line in [Line::RotationVectors, Line::GreatArcs, Line::EulerAngles] {
            for (from, to) in ends.iter().flat_map(|a| ends.iter().map(move |b| (*a, *b))) {
                for (t, end) in [(0.0, from), (1.0, to)] {
                    let off = line.between(from, to, t).angle_between(end);
                    assert!(off < 1e-6, "{line:?}: {off}");
                }
            }
        }
    }

    #[test]
    fn about_one_axis_all_are_the_same() {
        let turn = |angle: f64| DQuat::from_rotation_z(angle);
        for line in [Line::RotationVectors, Line::GreatArcs, Line::EulerAngles] {
            for (from, to, middle) in [(0.2, 1.4, 0.8), (-0.5, 0.7, 0.1), (3.0, -3.0, PI)] {
                let off = line.between(turn(from), turn(to), 0.5).angle_between(turn(middle));
                assert!(off < 1e-6, "{line:?} from {from} to {to}: {off}");
            }
        }
    }
}
