//! Minimum and maximum inertia of each dof.

use sinew_core::coordinates::CoordinatesError;
use sinew_core::dynamics::{OuterJoints, reflected_inertia};
use sinew_core::{JointStates, Tree};

use super::along_at;
use super::gravity::spread;
use crate::mechanism::Mechanism;
use crate::number::single;

/// Number of evaluated poses: home, and others spread over the ranges.
const POSES: u32 = 64;

/// Returns the minimum and maximum inertia of each dof in the evaluated poses, with all joints beyond the dof held.
/// The true minimum may be slightly smaller, and the true maximum slightly larger. O(n) per pose.
pub(crate) fn ranges<const N: usize>(
    mechanism: &Mechanism,
    tree: &Tree<N>,
) -> Result<Vec<[f64; 2]>, CoordinatesError> {
    let still = vec![0.0; tree.dof_count()];
    let mut pose = JointStates::rest(tree);
    let mut ranges = vec![[f64::INFINITY, 0.0]; tree.dof_count()];
    for number in 0..POSES {
        let q = if number == 0 { mechanism.home() } else { spread(mechanism, number) };
        let coordinates: Vec<f32> = q.iter().map(|q| single(*q)).collect();
        pose.set_coordinates(tree, &coordinates, &still)?;
        let inertias = reflected_inertia(tree, &pose, OuterJoints::Locked);
        let mut slots = ranges.iter_mut();
        let links = mechanism.bodies.iter().zip(mechanism.coordinate_ranges());
        for ((link, range), inertia) in links.zip(&inertias) {
            let own = q.get(range).unwrap_or_default();
            for axis in 0..link.joint.kind().dof_count() {
                let inertia = along_at(inertia, link, axis, own);
                if let Some([least, most]) = slots.next() {
                    *least = least.min(inertia);
                    *most = most.max(inertia);
                }
            }
        }
    }
    Ok(ranges)
}
