//! Friction of joints, in addition to that of their servos, converted to the servos' shafts.

use super::Actuation;
use super::joined_drive::JoinedDrive;
use crate::description::Description;
use crate::drive::DriveInputError;
use crate::number::single;

/// Friction at a servo's own shaft.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointFriction {
    /// Coulomb friction, N m.
    pub coulomb_nm: f32,
    /// Viscous friction, N m s.
    pub viscous_nm_s: f32,
}

impl Actuation {
    /// Returns, for each servo, the friction that the description gives its joint in addition to the servos' own,
    /// at the home pose. Servos that share a joint share its friction. For drives that move several dofs the
    /// friction is zero: the share of each servo would depend on how all dofs move. O(servos).
    pub fn joint_friction(&self, rig: &Description) -> Vec<JointFriction> {
        let mut all = vec![JointFriction::default(); self.servos.len()];
        for of in &self.drives {
            let [joint] = of.joints[..] else { continue };
            let [home] = rig.joints[joint].home()[..] else { continue };
            // `Description::check` ensures that home pose and unit are finite.
            let _ = self.share(rig, of, single(home), &mut all);
        }
        all
    }

    /// Distributes the friction of a joint of one dof to its servos, by virtual work.
    fn share(
        &self,
        rig: &Description,
        of: &JoinedDrive,
        home: f32,
        all: &mut [JointFriction],
    ) -> Result<(), DriveInputError> {
        let joint = &rig.joints[of.joints[0]];
        let pose = of.drive.at_joints(&[home])?;
        let (torques, speeds) = (pose.servo_torques(&[1.0])?, pose.servo_velocities(&[1.0])?);
        for (servo, (torque, speed)) in of.servos.iter().zip(torques.iter().zip(&speeds)) {
            let gear = self.servos[*servo].settings().gear;
            let (torque, speed) = (torque / gear, speed * gear);
            if torque.abs() > 0.0 {
                all[*servo] = JointFriction {
                    coulomb_nm: single(joint.friction) * torque.abs(),
                    viscous_nm_s: single(joint.damping) * torque / speed,
                };
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::new::arm;

    /// Virtual work: at any speed, the servos supply the power that the joint's friction takes.
    #[test]
    fn servos_overcome_what_their_joint_rubs() {
        let mut rig = arm(3).unwrap();
        let [joint, servo] =
            [&rig.drives[1].joints[0], &rig.drives[1].servos[0]].map(String::clone);
        let joint = rig.joints.iter().position(|other| other.name == joint).unwrap();
        let place = rig.servos.iter().position(|other| other.name == servo).unwrap();
        (rig.joints[joint].friction, rig.joints[joint].damping) = (0.02, 0.1);
        for (gear, direction) in [(1.0, 1), (3.0, -1)] {
            (rig.servos[place].gear, rig.servos[place].direction) = (gear, direction);
            let frictions = rig.actuation().unwrap().joint_friction(&rig);
            let joint_rad_s = 0.7;
            // The servo turns `gear` times for each turn of the joint.
            let own_rad_s = gear * joint_rad_s;
            let [own, others] = [place, 1 - place.min(1)].map(|at| frictions[at]);
            let lost_w =
                |coulomb: f64, viscous: f64, speed: f64| (coulomb + viscous * speed) * speed;
            let given = lost_w(own.coulomb_nm.into(), own.viscous_nm_s.into(), own_rad_s);
            assert!((given - lost_w(0.02, 0.1, joint_rad_s)).abs() < 1e-7, "{gear}: {own:?}");
            assert_eq!(others, super::JointFriction::default());
        }
    }
}
