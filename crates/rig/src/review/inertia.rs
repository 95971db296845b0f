//! Inertia against each dof, in one pose and over many.

use sinew_core::coordinates::CoordinatesError;
use sinew_core::dynamics::{OuterJoints, ReflectedInertia, reflected_inertia};
use sinew_core::{JointStates, Tree};

use super::gravity::spread;
use super::slides;
use crate::mechanism::Mechanism;
use crate::number::single;

/// Poses besides home, spread over the ranges.
const POSES: u32 = 48;

/// Inertia along each dof, by that of the joints in the pose `q`.
pub(super) fn of_dofs(mechanism: &Mechanism, joints: &[ReflectedInertia], q: &[f64]) -> Vec<f64> {
    let mut by_dof = Vec::new();
    let links = mechanism.bodies.iter().zip(mechanism.coordinate_ranges());
    for ((link, range), inertia) in links.zip(joints) {
        let (turns, _) = link.joint.axes(q.get(range).unwrap_or_default());
        for axis in 0..link.joint.kind().dof_count() {
            by_dof.push(if slides(link, axis) {
                f64::from(inertia.linear_kg)
            } else {
                turns.get(axis).map_or(0.0, |turn| {
                    let turn = turn.as_vec3();
                    f64::from(turn.dot(inertia.angular_kg_m2.mul_vec3(turn)))
                })
            });
        }
    }
    by_dof
}

/// The least and the greatest inertia against each dof, all joints beyond held: at home and in poses spread over the
/// ranges. A sample: the true extremes may be a little beyond. O(n) a pose.
pub(super) fn ranges<const N: usize>(
    mechanism: &Mechanism,
    tree: &Tree<N>,
) -> Result<Vec<[f64; 2]>, CoordinatesError> {
    let still = vec![0.0; tree.dof_count()];
    let mut ranges = vec![[f64::INFINITY, 0.0]; tree.dof_count()];
    let poses = (1..=POSES).map(|number| spread(mechanism, number));
    for q in std::iter::once(mechanism.home()).chain(poses) {
        let mut pose = JointStates::rest(tree);
        let coordinates: Vec<f32> = q.iter().map(|q| single(*q)).collect();
        pose.set_coordinates(tree, &coordinates, &still)?;
        let joints = reflected_inertia(tree, &pose, OuterJoints::Locked);
        for ([least, most], inertia) in ranges.iter_mut().zip(of_dofs(mechanism, &joints, &q)) {
            *least = least.min(inertia);
            *most = most.max(inertia);
        }
    }
    Ok(ranges)
}
