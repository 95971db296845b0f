//! The mannequin of the paper's figure, with human shape.

use glam::DVec3;
use sinew_figure::{BODIES, BODY_COUNT, FigureMotion};

use super::mannequin::{Mannequin, Part};

/// Bodies whose segment does not end at a joint: head, hands, feet. Their ends are the points after the joints' points.
const ENDS: [usize; 5] = [3, 7, 11, 14, 17];

/// Number of parts that make the trunk: the first ones of [`PARTS`].
const TRUNK: usize = 6;

/// Parts for a leg of [`LEG_M`].
const PARTS: [Part; 19] = [
    (12, 15, 0.0, 1.0, 0.09, 0.09),
    (0, 2, 0.0, 1.0, 0.108, 0.112),
    (2, 3, 0.0, 0.8, 0.118, 0.085),
    (2, 5, 0.35, 0.85, 0.095, 0.068),
    (2, 9, 0.35, 0.85, 0.095, 0.068),
    (3, 18, -0.1, 0.4, 0.05, 0.047),
    (3, 18, 0.52, 0.68, 0.09, 0.095),
    (5, 6, 0.0, 1.0, 0.05, 0.04),
    (6, 7, 0.0, 1.0, 0.04, 0.029),
    (7, 19, 0.1, 0.9, 0.034, 0.026),
    (9, 10, 0.0, 1.0, 0.05, 0.04),
    (10, 11, 0.0, 1.0, 0.04, 0.029),
    (11, 20, 0.1, 0.9, 0.034, 0.026),
    (12, 13, 0.0, 1.0, 0.08, 0.055),
    (13, 14, 0.0, 1.0, 0.055, 0.036),
    (14, 21, 0.0, 1.0, 0.042, 0.03),
    (15, 16, 0.0, 1.0, 0.08, 0.055),
    (16, 17, 0.0, 1.0, 0.055, 0.036),
    (17, 22, 0.0, 1.0, 0.042, 0.03),
];

/// Length of the leg for which [`PARTS`] are dimensioned.
const LEG_M: f64 = 0.86;

/// Length below which a segment has no direction, in metres.
const SHORTEST_M: f64 = 1e-3;

/// Indices of hands and feet among the points.
const HANDS_AND_FEET: [usize; 4] = [7, 11, 14, 17];

/// Indices of the feet and their ends among the points.
const ON_THE_GROUND: [usize; 4] = [14, 17, 21, 22];

impl Mannequin {
    /// Returns the human mannequin on a clip's skeleton.
    pub fn of_figure(motion: &FigureMotion) -> Self {
        let legs = BODIES
            .iter()
            .zip(&motion.segment_end_m)
            .filter(|(body, _)| body.name.starts_with("thigh") || body.name.starts_with("shank"));
        let girth = 0.5 * legs.map(|(_, end)| end.length()).sum::<f64>() / LEG_M;
        let ends = ENDS.map(|body| {
            let end = motion.segment_end_m[body];
            if end.length() > SHORTEST_M {
                return (body, end);
            }
            // In a skeleton without ends, the end continues in the direction of the bone from the parent.
            (body, motion.offset_m[body].normalize_or(DVec3::Y) * (0.16 * girth))
        });
        let joints = (0..BODY_COUNT).map(|body| (body, DVec3::ZERO));
        Self { points: joints.chain(ends).collect(), parts: PARTS.to_vec(), trunk: TRUNK, girth }
    }
}

/// Returns the height of the lowest point of a figure's feet.
pub(crate) fn feet_m(points: &[DVec3]) -> f64 {
    ON_THE_GROUND.map(|point| points[point].y).into_iter().fold(f64::INFINITY, f64::min)
}

/// Returns the largest horizontal distance of a hand or a foot from the pelvis, in metres.
pub fn reach_m(points: &[DVec3]) -> f64 {
    farthest_reach(points).length()
}

/// Returns the horizontal vector from the pelvis to the farthest hand or foot, in metres.
fn farthest_reach(points: &[DVec3]) -> DVec3 {
    let beside = HANDS_AND_FEET.map(|limb| (points[limb] - points[0]).with_y(0.0));
    beside
        .into_iter()
        .fold(DVec3::ZERO, |best, one| if one.length() > best.length() { one } else { best })
}

/// Returns the direction from which a figure's farthest reach is seen from the side and a little from the front:
/// the angle about the vertical from the z axis to the x axis.
pub fn side_view_rad(points: &[DVec3]) -> f64 {
    /// Turn from the exact side view, in which a figure looks flat.
    const TURN_RAD: f64 = 0.45;
    let reach = farthest_reach(points);
    let side = DVec3::new(reach.z, 0.0, -reach.x);
    // The side towards which the chest is turned.
    let chest = (points[12] - points[15]).cross(DVec3::Y);
    let side = if side.dot(chest) < 0.0 { -side } else { side };
    let turn = if side.cross(reach).y > 0.0 { TURN_RAD } else { -TURN_RAD };
    libm::atan2(side.x, side.z) + turn
}
