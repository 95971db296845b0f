//! Maps the figure's limbs to the landmarks of retargeting.

use sinew_retarget::{Landmark, Side};

/// Returns the landmark at the origin of a limb's body; `None` for bodies of the trunk.
pub fn limb_landmark(body: &str) -> Option<Landmark> {
    let (part, side) = body.rsplit_once('_')?;
    let side = if side == "l" { Side::Left } else { Side::Right };
    Some(match part {
        "upper_arm" => Landmark::Shoulder(side),
        "forearm" => Landmark::Elbow(side),
        "hand" => Landmark::Wrist(side),
        "thigh" => Landmark::Hip(side),
        "shank" => Landmark::Knee(side),
        "foot" => Landmark::Ankle(side),
        _ => return None,
    })
}
