//! Rigs as starting points for new ones.

mod arm;
mod face;
mod face_shapes;
mod shapes;
mod turn;

pub use arm::{ArmError, arm};
pub use face::face;

#[cfg(test)]
mod tests {
    use sinew_core::Tree;

    use super::*;
    use crate::toml_file::{read, write};

    #[test]
    fn every_arm_is_a_rig() {
        for joints in 1..=40 {
            let rig = arm(joints).unwrap();
            let mechanism = rig.mechanism().unwrap();
            assert_eq!(mechanism.bodies.len(), joints + 1);
            let tree: Tree<64> = mechanism.tree().unwrap();
            assert_eq!(tree.coordinate_count(), joints);
            assert_eq!(rig.servos.len(), joints);
            assert_eq!(read(&write(&rig)).unwrap(), rig);
        }
        assert_eq!(arm(0), Err(ArmError { joints: 0 }));
        assert_eq!(arm(41), Err(ArmError { joints: 41 }));
    }

    #[test]
    fn a_face_is_a_rig_without_masses_whose_channels_fit_one_driver() {
        let rig = face();
        let mechanism = rig.mechanism().unwrap();
        assert!(mechanism.bodies.iter().all(|link| link.mass_kg <= 0.0));
        assert!(mechanism.bodies.iter().skip(1).all(|link| link.speed.is_finite()
            && link.acceleration.is_finite()
            && link.ranges.len() == 1));
        // Jaw 1, eyes 4, lids 4, brows 2, neck 3.
        assert_eq!(rig.servos.len(), 14);
        assert_eq!(rig.limits.len(), 2);
        assert_eq!(rig.face_shapes.len(), 15 + 52);
        assert_eq!(read(&write(&rig)).unwrap(), rig);
    }
}
