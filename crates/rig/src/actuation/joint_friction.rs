//! What joints rub beside their servos, as servos have to overcome it.

use super::Actuation;
use super::joined_drive::JoinedDrive;
use crate::description::Description;
use crate::drive::DriveInputError;
use crate::number::single;

/// Friction at a servo's own shaft.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct JointFriction {
    /// Coulomb, N m.
    pub coulomb_nm: f32,
    /// Viscous, N m s.
    pub viscous_nm_s: f32,
}

impl Actuation {
    /// By servo: the friction that the description gives its joint beside that of the servos, at the home pose; servos
    /// that share a joint share it. Of drives that move several dofs it is none: which of their servos has to
    /// overcome it is a matter of how all of them move. O(servos).
    pub fn joint_friction(&self, rig: &Description) -> Vec<JointFriction> {
        let mut all = vec![JointFriction::default(); self.servos.len()];
        for of in &self.drives {
            let [joint] = of.joints[..] else { continue };
            let [home] = rig.joints[joint].home()[..] else { continue };
            // A home pose is finite, and so is the unit: `Description::check`.
            let _ = self.share(rig, of, single(home), &mut all);
        }
        all
    }

    /// Gives the friction of a joint of one dof to its servos, by virtual work.
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

    /// By virtual work: what the servos give at any speed is what the joint takes.
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
            // The servo turns by its gear for a turn of the joint.
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
