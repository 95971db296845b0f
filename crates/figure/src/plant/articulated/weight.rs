//! Checks that every joint has inertia to accelerate. Bodies without mass or extent may leave a joint without it.

use glam::DVec3;

use crate::plant::{Mechanism, MovingPose, PlantError, Pose};

/// Minimum inertia of a joint while the joints before it move freely, as a share of its inertia while they are held.
/// The value is far above rounding errors, and far below that of any rig.
const LEAST: f64 = 1e-9;

/// Refuses a joint that nothing resists in the rig's initial pose. O(n³), once per plant.
pub(super) fn check(mechanism: &Mechanism, start: &[MovingPose]) -> Result<(), PlantError> {
    let axes = motion_axes(mechanism, start);
    let mut matrix = mass_matrix(mechanism, start, &axes);
    let inertias: Vec<f64> = (0..axes.len()).map(|axis| matrix[axis][axis]).collect();
    // Gaussian elimination: a pivot is the remaining inertia of an axis.
    for (pivot, axis) in axes.iter().enumerate() {
        let row = matrix[pivot].clone();
        // The condition is written to refuse NaN.
        let resists = row[pivot] > LEAST * inertias[pivot];
        if !resists {
            return Err(PlantError::Weightless { body: axis.body });
        }
        for below in &mut matrix[pivot + 1..] {
            let factor = below[pivot] / row[pivot];
            for (slot, of_pivot) in below.iter_mut().zip(&row) {
                *slot -= factor * of_pivot;
            }
        }
    }
    Ok(())
}

/// The motion along a dof of a joint: the velocity of the body at unit speed of the dof, world axes.
struct MotionAxis {
    body: usize,
    angular: DVec3,
    /// Velocity of the body's point at the world's origin.
    linear: DVec3,
}

impl MotionAxis {
    /// Returns the velocity of a point that moves with the body.
    fn at(&self, point_m: DVec3) -> DVec3 {
        self.linear + self.angular.cross(point_m)
    }
}

fn motion_axes(mechanism: &Mechanism, start: &[MovingPose]) -> Vec<MotionAxis> {
    let mut axes = Vec::new();
    for (body, (link, at)) in mechanism.bodies.iter().zip(start).enumerate() {
        let in_parent = link.parent.map_or(at.pose, |parent| start[parent].pose.inside(&at.pose));
        let placement = Pose { rotation: link.rotation, position_m: link.position_m };
        let in_joint = placement.inside(&in_parent);
        let (turns, slides) = link.joint.axes(&link.joint.along(&in_joint));
        for axis in turns {
            let angular = at.pose.rotation * axis;
            axes.push(MotionAxis { body, angular, linear: at.pose.position_m.cross(angular) });
        }
        for axis in slides {
            axes.push(MotionAxis { body, angular: DVec3::ZERO, linear: at.pose.rotation * axis });
        }
    }
    axes
}

/// Computes the mass matrix: `M[i][j] = Σ ωᵢᵀ I ωⱼ + m vᵢᵀ vⱼ` over the bodies that both axes move, plus the
/// rotors.
fn mass_matrix(mechanism: &Mechanism, start: &[MovingPose], axes: &[MotionAxis]) -> Vec<Vec<f64>> {
    let mut matrix = vec![vec![0.0; axes.len()]; axes.len()];
    for (body, (link, at)) in mechanism.bodies.iter().zip(start).enumerate() {
        let center_m = at.pose.point(link.center_of_mass_m);
        let moving: Vec<usize> =
            (0..axes.len()).filter(|axis| supports(mechanism, axes[*axis].body, body)).collect();
        for one in &moving {
            let spin = at.pose.rotation.conjugate() * axes[*one].angular;
            let moment = at.pose.rotation * (link.inertia_kg_m2 * spin);
            let momentum = axes[*one].at(center_m) * link.mass_kg;
            for other in &moving {
                let MotionAxis { angular, .. } = axes[*other];
                matrix[*one][*other] +=
                    angular.dot(moment) + axes[*other].at(center_m).dot(momentum);
            }
        }
    }
    for (index, axis) in axes.iter().enumerate() {
        matrix[index][index] += mechanism.bodies[axis.body].rotor_inertia;
    }
    matrix
}

/// Returns whether the joint of one body moves another body.
fn supports(mechanism: &Mechanism, joint: usize, body: usize) -> bool {
    std::iter::successors(Some(body), |body| mechanism.bodies[*body].parent).any(|one| one == joint)
}
