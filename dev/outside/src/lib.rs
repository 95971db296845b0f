//! Somebody else's crate: an arm for a board without a heap, made only with the public interface of `sinew-core`.

#![no_std]

use sinew_core::coordinates::CoordinatesError;
use sinew_core::prelude::*;
use sinew_core::{JointControllerError, JointTickError, TreeError};

/// Number of joints of the arm.
pub const JOINTS: usize = 6;

/// Returns the arm of the core's first example.
///
/// # Errors
/// [`TreeError`] if its numbers are changed to invalid numbers.
pub fn arm() -> Result<Tree<JOINTS>, TreeError> {
    let inertia = Inertia::of_box(0.2, Vec3::Y * 0.05, Vec3::new(0.04, 0.1, 0.04));
    let link = |i: usize| Body::revolute(None, [Vec3::Y, Vec3::X][i % 2], Vec3::Y * 0.1, inertia);
    Tree::serial_chain(&[0, 1, 2, 3, 4, 5].map(link))
}

/// Returns the arm's controller.
///
/// # Errors
/// [`JointControllerError`] if the stiffness is negative or not finite.
pub fn controller(
    arm: Tree<JOINTS>,
    kp: f32,
) -> Result<JointController<JOINTS>, JointControllerError> {
    JointController::new(arm, kp, &[2.0; JOINTS])
}

/// Returns the torques of a tick, in N m, as the loop of a board would.
///
/// # Errors
/// [`JointTickError`] if a number is invalid. The caller must then bring the servos to a safe state.
pub fn tick(
    controller: &mut JointController<JOINTS>,
    target_rad: &[f32; JOINTS],
    q_rad: &[f32; JOINTS],
    qd_rad_s: &[f32; JOINTS],
) -> Result<[f32; JOINTS], JointTickError> {
    let mut torques_nm = [0.0; JOINTS];
    controller.tick(target_rad, q_rad, qd_rad_s, &mut torques_nm)?;
    Ok(torques_nm)
}

/// Returns the torques in N m that hold the arm.
///
/// # Errors
/// [`CoordinatesError`] if a number is invalid.
pub fn holding(
    arm: &Tree<JOINTS>,
    q_rad: &[f32; JOINTS],
) -> Result<[f32; JOINTS], CoordinatesError> {
    let mut torques_nm = [0.0; JOINTS];
    arm.gravity(q_rad, &mut torques_nm)?;
    Ok(torques_nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arm_that_is_where_it_should_be_is_held() {
        let q_rad = [0.1, 0.2, -0.3, 0.4, 0.5, -0.6];
        let mut controller = controller(arm().unwrap(), 200.0).unwrap();
        let torques_nm = tick(&mut controller, &q_rad, &q_rad, &[0.0; JOINTS]).unwrap();
        let holding_nm = holding(&arm().unwrap(), &q_rad).unwrap();
        for (got, expected) in torques_nm.iter().zip(holding_nm) {
            assert!((got - expected).abs() < 1e-6, "{torques_nm:?} {holding_nm:?}");
        }
    }

    #[test]
    fn a_tree_has_room_for_256_bodies() {
        let link = Body::revolute(None, Vec3::X, Vec3::Y * 0.01, Inertia::default());
        assert_eq!(Tree::<256>::serial_chain(&[link; 256]).unwrap().len(), 256);
    }
}
