//! Two-bone inverse kinematics with a pole vector, in closed form.

use glam::DVec3;

/// A solved limb: shoulder, elbow, wrist, or hip, knee, ankle. All vectors are unit vectors, in the frame of the
/// inputs of [`solve`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TwoBones {
    /// Direction of the upper bone.
    pub upper: DVec3,
    /// Direction of the lower bone.
    pub lower: DVec3,
    /// Hinge axis: a right-handed turn about it bends the lower bone away from the upper bone. Also defined in a
    /// straight limb.
    pub hinge: DVec3,
    /// Angle between the bones' directions: 0 in a straight limb.
    pub flexion_rad: f64,
}

/// Longest reach, as a share of the limb's length. 0.998 leaves 7 degrees of flexion, which keeps a joint from
/// snapping straight.
pub(super) const LONGEST_REACH: f64 = 0.998;

/// Bends a limb of two bones so that it reaches from `root` to `target`, with the middle joint towards `pole`.
///
/// All vectors are in one frame. `pole` is a direction of any length that is not parallel to the limb. A target
/// out of reach is approached as far as [`LONGEST_REACH`] allows.
pub(super) fn solve(
    root: DVec3,
    target: DVec3,
    upper_m: f64,
    lower_m: f64,
    pole: DVec3,
) -> TwoBones {
    let to_target = target - root;
    let axis = to_target.normalize();
    let reach_m = to_target.length().min(LONGEST_REACH * (upper_m + lower_m));
    let side = (pole - axis * pole.dot(axis)).normalize();

    // Law of cosines: where the middle joint projects onto the axis, and its height over the axis.
    let along_m = (reach_m * reach_m + upper_m * upper_m - lower_m * lower_m) / (2.0 * reach_m);
    let height_m = libm::sqrt((upper_m * upper_m - along_m * along_m).max(0.0));
    let upper = (axis * along_m + side * height_m) / upper_m;
    let lower = (axis * (reach_m - along_m) - side * height_m) / lower_m;
    TwoBones {
        upper: upper.normalize(),
        lower: lower.normalize(),
        hinge: side.cross(axis),
        flexion_rad: libm::atan2(upper.cross(lower).length(), upper.dot(lower)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reaches_the_target_and_bends_towards_the_pole() {
        let (root, pole) = (DVec3::new(0.1, 1.4, 0.0), DVec3::new(0.3, -1.0, 0.1));
        for target in
            [DVec3::new(0.2, 1.5, 0.5), DVec3::new(-0.2, 1.3, 0.2), DVec3::new(0.4, 1.0, -0.1)]
        {
            let limb = solve(root, target, 0.29, 0.27, pole);
            let wrist = root + limb.upper * 0.29 + limb.lower * 0.27;
            assert!((wrist - target).length() < 1e-12);
            let elbow_side = limb.upper - limb.lower;
            assert!(elbow_side.dot(pole) > 0.0);
            let turned = limb.upper * libm::cos(limb.flexion_rad)
                + limb.hinge.cross(limb.upper) * libm::sin(limb.flexion_rad);
            assert!((turned - limb.lower).length() < 1e-12);
        }
    }

    #[test]
    fn stops_short_of_a_target_out_of_reach() {
        let limb = solve(DVec3::ZERO, DVec3::Z * 2.0, 0.3, 0.3, DVec3::Y);
        let reach = (limb.upper * 0.3 + limb.lower * 0.3).length();
        assert!((reach - 0.6 * LONGEST_REACH).abs() < 1e-12);
        assert!(limb.flexion_rad.to_degrees() > 7.0);
    }
}
