//! Defaults of a joint's inertia, friction, effort and speed, from the servos that move the joint.

use super::Actuation;
use super::joined_drive::JoinedDrive;
use crate::description::{Description, JointType};
use crate::drive::{DriveInputError, DrivePose};
use crate::number::single;
use crate::servo::Servo;

/// Default values of a joint, from the servos of its drive, at the home pose. A joint of several dofs has one value
/// of each quantity for all its dofs: the mean inertia and friction, and the smallest limits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JointDefaults {
    /// Inertia that rotors add to each dof, kg m² (kg for a slide).
    pub rotor_inertia: f64,
    /// Coulomb friction, N m (N for a slide).
    pub friction: f64,
    /// Viscous friction, N m s (N s/m for a slide).
    pub damping: f64,
    /// Maximum effort when only one dof acts, N m (N for a slide).
    pub effort: f64,
    /// Maximum speed when only one dof moves, rad/s (m/s for a slide). For mimic joints, the speed at which they move
    /// with their servos.
    pub speed: f64,
}

/// Values of one dof, or of one servo at its shaft.
#[derive(Debug, Clone, Copy)]
struct DofDefaults {
    inertia: f32,
    friction: f32,
    damping: f32,
    effort: f32,
    speed: f32,
}

impl Actuation {
    /// Returns the default values of each joint of a description, at its home pose; `None` for a joint without
    /// servos.
    pub fn joint_defaults(&self, rig: &Description) -> Vec<Option<JointDefaults>> {
        let mut defaults = vec![None; rig.joints.len()];
        for drive in &self.drives {
            // `Description::check` ensures that a home pose has one finite number for each dof.
            let Ok(of_dofs) = self.of_dofs(rig, drive) else { continue };
            let mut rest = &of_dofs[..];
            for joint in &drive.joints {
                let count = rig.joints[*joint].kind.dof_count().min(rest.len());
                let (own, behind) = rest.split_at(count);
                rest = behind;
                defaults[*joint] = (!own.is_empty()).then(|| joined(own));
            }
        }
        defaults
    }

    fn of_dofs(
        &self,
        rig: &Description,
        drive: &JoinedDrive,
    ) -> Result<Vec<DofDefaults>, DriveInputError> {
        let home: Vec<f32> = drive.joints.iter().flat_map(|joint| home(rig, *joint)).collect();
        let pose = drive.drive.at_joints(&home)?;
        let servos: Vec<&Servo> = drive.servos.iter().map(|servo| &self.servos[*servo]).collect();
        let each =
            |of: fn(&Servo) -> f32| -> Vec<f32> { servos.iter().map(|servo| of(servo)).collect() };
        let gear = |servo: &Servo| servo.settings().gear.abs();
        let inertia = pose.reflected_to_joints(&each(Servo::shaft_inertia))?;
        let damping = pose.reflected_to_joints(&each(|servo| {
            servo.settings().damping_nm_s * servo.settings().gear * servo.settings().gear
        }))?;
        let friction: Vec<f32> =
            servos.iter().map(|servo| servo.settings().friction_nm * gear(servo)).collect();
        let torque: Vec<f32> =
            servos.iter().map(|servo| servo.settings().torque_nm * gear(servo)).collect();
        let speed: Vec<f32> =
            servos.iter().map(|servo| servo.settings().speed_rad_s / gear(servo)).collect();
        let speeds = speeds(&pose, &speed)?;
        (0..home.len())
            .map(|dof| {
                let alone = unit(home.len(), dof);
                let lost = pose.servo_velocities(&alone)?;
                Ok(DofDefaults {
                    inertia: inertia[dof],
                    friction: friction
                        .iter()
                        .zip(&lost)
                        .map(|(friction, speed)| friction * speed.abs())
                        .sum(),
                    damping: damping[dof],
                    effort: least_share(&torque, &pose.servo_torques(&alone)?),
                    speed: speeds[dof],
                })
            })
            .collect()
    }
}

/// Returns the maximum speed of each dof when it moves alone. Mimic joints cannot move alone: their speeds are
/// those at which they move with their servos.
fn speeds(pose: &DrivePose<'_>, of_servos: &[f32]) -> Result<Vec<f32>, DriveInputError> {
    let (dofs, servos) = (pose.joints().len(), of_servos.len());
    if dofs <= servos {
        return (0..dofs)
            .map(|dof| Ok(least_share(of_servos, &pose.servo_velocities(&unit(dofs, dof))?)))
            .collect();
    }
    let mut speeds = vec![0.0; dofs];
    for (servo, speed) in of_servos.iter().enumerate() {
        let moved = pose.joint_velocities(&unit(servos, servo))?;
        for (sum, share) in speeds.iter_mut().zip(&moved) {
            *sum += speed * share.abs();
        }
    }
    Ok(speeds)
}

/// Returns the factor by which `asked` may grow until the first servo reaches its limit.
fn least_share(limits: &[f32], asked: &[f32]) -> f32 {
    let shares = limits.iter().zip(asked).filter(|(_, asked)| asked.abs() > 0.0);
    shares.map(|(limit, asked)| limit / asked.abs()).fold(f32::INFINITY, f32::min)
}

fn unit(count: usize, of: usize) -> Vec<f32> {
    (0..count).map(|index| if index == of { 1.0 } else { 0.0 }).collect()
}

fn home(rig: &Description, joint: usize) -> Vec<f32> {
    let joint = &rig.joints[joint];
    match joint.kind {
        // The home of a ball joint is its zero pose.
        JointType::Spherical => vec![0.0; 3],
        _ => joint.home().into_iter().map(single).collect(),
    }
}

fn joined(dofs: &[DofDefaults]) -> JointDefaults {
    let mean = |of: fn(&DofDefaults) -> f32| {
        dofs.iter().map(|dof| f64::from(of(dof))).sum::<f64>() / dofs.len() as f64
    };
    let least = |of: fn(&DofDefaults) -> f32| {
        dofs.iter().map(|dof| f64::from(of(dof))).fold(f64::INFINITY, f64::min)
    };
    JointDefaults {
        rotor_inertia: mean(|dof| dof.inertia),
        friction: mean(|dof| dof.friction),
        damping: mean(|dof| dof.damping),
        effort: least(|dof| dof.effort),
        speed: least(|dof| dof.speed),
    }
}
