//! Poses that Python sends.

use anyhow::ensure;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use crate::arrays::single;

/// Permitted distance beyond a range, rad or m, which rounding may cause.
const ROUNDING: f64 = 1e-5;

/// Returns the pose with all joints that follow another one where their leaders put them. Fails if a joint is outside
/// its range.
pub(super) fn followed(mechanism: &Mechanism, q: &[f32]) -> anyhow::Result<Vec<f32>> {
    let mut followed: Vec<f64> = q.iter().copied().map(f64::from).collect();
    mechanism.ties().follow(&mut followed);
    let followed: Vec<f32> = followed.into_iter().map(single).collect();
    let ranges = mechanism.coordinate_ranges();
    for (link, range) in mechanism.bodies.iter().zip(ranges) {
        if matches!(link.joint, JointModel::Spherical | JointModel::Free) {
            continue;
        }
        for (number, [least, most]) in followed[range].iter().zip(&link.ranges) {
            let number = f64::from(*number);
            ensure!(
                (least - ROUNDING..=most + ROUNDING).contains(&number),
                "`{}`: expected {least:.4} to {most:.4}, found {number:.4}",
                link.joint_name
            );
        }
    }
    Ok(followed)
}
