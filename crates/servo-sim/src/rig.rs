//! The servos of a rig, each with its own separate load at the rig's home pose.
//!
//! This is a simplification of [`RigPlant`](crate::plant::RigPlant): a servo does not feel the motion of the others. It
//! moves the inertia of its drive at the home pose, against gravity. If a servo alone turns one hinge, one turn for one
//! turn, gravity depends on its angle; otherwise gravity is that of the home pose at all angles. The ends of the
//! servo's range are stops.

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use sinew_rig::actuation::{Actuation, JoinedDrive};
use sinew_rig::description::{DescriptionError, Servo as DescribedServo, ServoModel};
use sinew_rig::drive::DriveInputError;
use sinew_rig::mechanism::{InverseDynamics, JointModel};
use sinew_rig::servo::{Address, Servo};
use sinew_rig::{Description, Mechanism};
use thiserror::Error;

use crate::load::Arm;
use crate::model::{Parameters, ParametersError};

/// Minimum inertia that a servo moves: its horn, kg m².
pub(crate) const HORN_KG_M2: f64 = 1e-4;
/// Maximum deviation from one turn of the joint for one turn of the servo.
const DIRECT: f32 = 1e-3;

/// A servo of a rig, with its load.
#[derive(Debug, Clone, PartialEq)]
pub struct RigServo {
    /// Name of the servo in the rig.
    pub name: String,
    /// Name of its bus.
    pub bus: String,
    /// Address on the bus: an id, or a channel of a pulse generator.
    pub address: Address,
    /// Parameters of the servo's kind.
    pub kind: Parameters,
    /// Load on the servo's own shaft; positions are zero where its encoder counts zero.
    pub load: Arm,
    /// Position at the home pose, rad, zero where its encoder counts zero.
    pub home_rad: f64,
}

/// The reason why a rig's servos cannot be simulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RigServosError {
    /// The drives and servos of the description do not match.
    #[error(transparent)]
    Description(#[from] DescriptionError),
    /// The core refuses the mechanism.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The home pose is invalid.
    #[error("its home pose: {0}")]
    Home(#[from] CoordinatesError),
    /// A drive refuses the home pose.
    #[error("a drive at its home pose: {0}")]
    Drive(#[from] DriveInputError),
    /// The figures of a kind of servo contradict each other.
    #[error(transparent)]
    Parameters(#[from] ParametersError),
    /// The rig has no servo with this name.
    #[error("it has no servo {0:?}")]
    NoServo(String),
}

impl RigServo {
    /// Returns the id, or `None` for a servo that takes pulses.
    pub fn id(&self) -> Option<u8> {
        match self.address {
            Address::Id(id) => Some(id),
            Address::Channel(_) => None,
        }
    }
}

/// Returns all servos of a rig, in its order. O(servos · bodies).
///
/// # Errors
/// [`RigServosError`] contains the cause.
pub fn servos(
    description: &Description,
    mechanism: &Mechanism,
) -> Result<Vec<RigServo>, RigServosError> {
    let actuation = description.actuation()?;
    let mut joints = Joints::of(description, mechanism)?;
    let mut servos = Vec::new();
    for (described, servo) in description.servos.iter().zip(&actuation.servos) {
        // `actuation` has already refused unknown models.
        let Some(model) = description.servo_model(&described.model) else { continue };
        let kind = kind(description, described, &model)?;
        let middle = 0.5 * kind.range_rad;
        servos.push(RigServo {
            name: described.name.clone(),
            bus: described.bus.clone(),
            address: described.address,
            load: Arm {
                stops_rad: servo.settings().range_rad.map(|end| f64::from(end) + middle),
                ..Arm::default()
            },
            home_rad: middle,
            kind,
        });
    }
    for drive in &actuation.drives {
        joints.load(&actuation, drive, &mut servos)?;
    }
    Ok(servos)
}

/// Returns the parameters of a rig's servo. A hobby servo gets the pulses of the rig's file. Its range is centred on
/// position zero, and is large enough for all its pulses.
pub(crate) fn kind(
    description: &Description,
    servo: &DescribedServo,
    model: &ServoModel,
) -> Result<Parameters, ParametersError> {
    let mut kind = Parameters::of_model(model)?;
    if let Some(pulses) = description.pulses(servo) {
        let [least, most] = pulses.range_rad();
        kind.range_rad = 2.0 * f64::max(-least, most);
        kind.pulses = pulses;
    }
    Ok(kind)
}

/// The efforts of all joints near the home pose.
struct Joints<'r> {
    mechanism: &'r Mechanism,
    dynamics: InverseDynamics,
    home: Vec<f32>,
    /// For each joint of the description: its link, its first dof and its first coordinate.
    places: Vec<Option<(usize, usize, usize)>>,
    at_rest: Vec<f32>,
}

impl<'r> Joints<'r> {
    fn of(description: &Description, mechanism: &'r Mechanism) -> Result<Self, RigServosError> {
        // The servos themselves simulate the rotors.
        let mut bare = mechanism.clone();
        bare.bodies.iter_mut().for_each(|link| link.rotor_inertia = 0.0);
        let (mut dof, mut coordinate, mut starts) = (0, 0, Vec::new());
        for link in &mechanism.bodies {
            starts.push((dof, coordinate));
            dof += link.joint.kind().dof_count();
            coordinate += link.joint.kind().coordinate_count();
        }
        let place = |name: &str| {
            let link = mechanism.bodies.iter().position(|link| link.joint_name == name)?;
            Some((link, starts[link].0, starts[link].1))
        };
        let places = description.joints.iter().map(|joint| place(&joint.name)).collect();
        let mut dynamics = InverseDynamics::of(&bare)?;
        let home: Vec<f32> = mechanism.home().into_iter().map(single).collect();
        let rest = vec![0.0; dof];
        let at_rest = dynamics.efforts(&home, &rest, &rest)?.to_vec();
        Ok(Self { mechanism, dynamics, home, places, at_rest })
    }

    /// Computes the load of each servo of a drive, as if only this servo moved.
    fn load(
        &mut self,
        actuation: &Actuation,
        drive: &JoinedDrive,
        servos: &mut [RigServo],
    ) -> Result<(), RigServosError> {
        let mut dofs = Vec::new();
        let mut home = Vec::new();
        for joint in &drive.joints {
            // A checked rig has a link for each joint.
            let Some((link, first, coordinate)) = self.places[*joint] else { return Ok(()) };
            let link = &self.mechanism.bodies[link];
            let count = link.joint.kind().dof_count();
            dofs.extend(first..first + count);
            // The home pose of a ball joint has a rotation vector of zero.
            match link.joint {
                JointModel::Spherical => home.extend([0.0; 3]),
                _ => home.extend_from_slice(&self.home[coordinate..coordinate + count]),
            }
        }
        let pose = drive.drive.at_joints(&home)?;
        let held_nm = pose.servo_torques(&picked(&dofs, &self.at_rest))?;
        for (place, index) in drive.servos.iter().enumerate() {
            let own: &Servo = &actuation.servos[*index];
            let gear = own.settings().gear;
            let mut alone = vec![0.0; drive.servos.len()];
            alone[place] = 1.0;
            let moved = pose.joint_velocities(&alone)?;
            let share = pose.servo_velocities(&moved)?[place];
            let servo = &mut servos[*index];
            let middle = 0.5 * servo.kind.range_rad;
            let home_rad = gear * pose.servos()[place] + own.settings().offset_rad;
            servo.home_rad = middle + f64::from(home_rad);
            let at_shaft = pose.servo_torques(&self.accelerated(&dofs, &moved)?)?[place];
            // Servos that share a joint also share its inertia.
            let inertia = if share > 0.0 { at_shaft / share / (gear * gear) } else { 0.0 };
            servo.load.inertia_kg_m2 = f64::from(inertia).max(HORN_KG_M2);
            // Turns of the hinge for one turn of the servo, if this servo alone moves a single hinge.
            let ratio = moved[0] / gear;
            let hinge = match (drive.joints.as_slice(), drive.servos.len()) {
                ([joint], 1) if (ratio.abs() - 1.0).abs() < DIRECT => self.hinge(*joint),
                _ => None,
            };
            if let Some((dof, coordinate)) = hinge {
                let cosine = f64::from(self.at_rest[dof] * ratio);
                let quarter = f64::from(self.quarter_on(dof, coordinate)?);
                servo.load.gravity_nm = libm::hypot(cosine, quarter);
                servo.load.level_rad = servo.home_rad - libm::atan2(-quarter, cosine);
            } else {
                servo.load.torque_nm = -f64::from(held_nm[place] / gear);
            }
        }
        Ok(())
    }

    /// Returns dof and coordinate of a joint, if it is a hinge.
    fn hinge(&self, joint: usize) -> Option<(usize, usize)> {
        let (link, dof, coordinate) = self.places[joint]?;
        matches!(self.mechanism.bodies[link].joint, JointModel::Revolute(_))
            .then_some((dof, coordinate))
    }

    /// Returns the gravity effort of a hinge a quarter turn from home.
    fn quarter_on(&mut self, dof: usize, coordinate: usize) -> Result<f32, RigServosError> {
        let mut q = self.home.clone();
        q[coordinate] += std::f32::consts::FRAC_PI_2;
        let rest = vec![0.0; self.at_rest.len()];
        Ok(self.dynamics.efforts(&q, &rest, &rest)?[dof])
    }

    /// Returns the efforts of dofs for their accelerations, without gravity.
    fn accelerated(&mut self, dofs: &[usize], qdd: &[f32]) -> Result<Vec<f32>, RigServosError> {
        let mut all = vec![0.0; self.at_rest.len()];
        for (dof, qdd) in dofs.iter().zip(qdd) {
            all[*dof] = *qdd;
        }
        let rest = vec![0.0; all.len()];
        let efforts = self.dynamics.efforts(&self.home, &rest, &all)?;
        Ok(dofs.iter().map(|at| efforts[*at] - self.at_rest[*at]).collect())
    }
}

fn picked(dofs: &[usize], efforts: &[f32]) -> Vec<f32> {
    dofs.iter().map(|at| efforts[*at]).collect()
}

#[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
fn single(number: f64) -> f32 {
    number as f32
}

#[cfg(test)]
mod tests {
    use sinew_rig::new::arm;

    use super::*;
    use crate::load::{Load as _, Shaft};

    /// A servo's load equals the rig's inverse dynamics, for any angle of its own joint.
    #[test]
    fn each_servo_of_an_arm_holds_its_part_of_the_rig() {
        let mut description = arm(5).unwrap();
        // One servo is mirrored, with another zero.
        description.servos[2].direction = -1;
        description.servos[2].offset_rad = Some(0.3);
        let mechanism = description.mechanism().unwrap();
        let servos = servos(&description, &mechanism).unwrap();
        let mut dynamics = InverseDynamics::of(&mechanism).unwrap();
        let home: Vec<f32> = mechanism.home().into_iter().map(single).collect();
        let rest = vec![0.0; 5];
        assert_eq!(servos.len(), 5);
        for (joint, servo) in servos.iter().enumerate() {
            let direction = f64::from(description.servos[joint].direction);
            let offset = description.servos[joint].offset_rad.unwrap_or(0.0);
            for turned in [0.0_f32, 0.4, -1.1] {
                let mut q = home.clone();
                q[joint] += turned;
                let held = f64::from(dynamics.efforts(&q, &rest, &rest).unwrap()[joint]);
                let middle = 0.5 * servo.kind.range_rad;
                let position = middle + direction * f64::from(q[joint]) + offset;
                let pull =
                    servo.load.torque_nm(Shaft { position_rad: position, velocity_rad_s: 0.0 });
                // Tolerance for f32 against f64, at up to 0.1 N m.
                assert!((pull + direction * held).abs() < 1e-6, "{joint}: {pull} {held}");
                if turned == 0.0 {
                    assert!((servo.home_rad - position).abs() < 1e-6);
                }
            }
            let mut qdd = rest.clone();
            qdd[joint] = 1.0;
            let rotor = mechanism.bodies[joint + 1].rotor_inertia;
            let moved = dynamics.efforts(&home, &rest, &qdd).unwrap()[joint];
            let held = dynamics.efforts(&home, &rest, &rest).unwrap()[joint];
            let inertia = (f64::from(moved - held) - rotor).max(HORN_KG_M2);
            assert!((servo.load.inertia_kg_m2 - inertia).abs() < 1e-6);
        }
        assert!(servos[1].load.inertia_kg_m2 > 4.0 * HORN_KG_M2);
    }

    #[test]
    fn a_face_has_a_load_for_each_servo() {
        let description = sinew_rig::new::face();
        let mechanism = description.mechanism().unwrap();
        for servo in servos(&description, &mechanism).unwrap() {
            let load = servo.load;
            assert!(load.inertia_kg_m2 >= HORN_KG_M2 && load.gravity_nm.is_finite());
            assert!(load.torque_nm.is_finite() && servo.home_rad.is_finite(), "{servo:?}");
        }
    }
}
