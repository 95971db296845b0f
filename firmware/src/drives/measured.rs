//! Conversion of servos' readings to the state of joints, by the drives.

use sinew_rig::board::BoardDrive;
use sinew_rig::drive::{DRIVE_CAPACITY, DriveInputError, Numbers};
use sinew_servo_bus::Effort;

use super::{Condition, Drives, InputError};

/// The measured state of one dof.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Measured {
    /// Position, rad or m; for a ball joint a component of the rotation vector.
    pub position: f32,
    /// Velocity, rad/s or m/s; for a ball joint in body axes.
    pub velocity: f32,
    /// Effort of the motors computed from their currents, including friction, N m or N; `None` without current
    /// sensors.
    pub effort: Option<f32>,
    /// Age of the oldest reading that was used, in ticks.
    pub age_ticks: u32,
}

impl<const BODIES: usize, const DOFS: usize, const SERVOS: usize> Drives<'_, BODIES, DOFS, SERVOS> {
    /// Returns the measured state of each dof; `None` if no drive moves the dof, or a servo of its drive was never
    /// read.
    ///
    /// # Errors
    /// [`InputError`], as in [`Self::step`].
    pub fn measured(
        &self,
        conditions: &[Condition],
        out: &mut [Option<Measured>],
    ) -> Result<(), InputError> {
        Condition::check_all(self.servos.len(), conditions)?;
        InputError::check_count("dofs out", self.rig.dofs().len(), out.len())?;
        out.fill(None);
        for (index, drive) in self.rig.drives().iter().enumerate() {
            let Some(shafts) = self.shafts(drive, conditions) else { continue };
            shafts.to_joints(drive, out).map_err(|_| InputError::Drive { drive: index })?;
        }
        Ok(())
    }

    /// Returns the measured positions of a drive's servos at its shafts; `None` if a servo was never read.
    pub(super) fn shaft_positions(
        &self,
        drive: &BoardDrive,
        conditions: &[Condition],
    ) -> Option<Numbers> {
        let mut positions = Numbers::new();
        for index in &drive.servos {
            let index = usize::from(*index);
            let read = conditions.get(index)?.feedback?;
            // There is room: a drive's number of servos is limited.
            let _ = positions.push(self.servos.get(index)?.shaft_position(read.position_rad));
        }
        Some(positions)
    }

    /// Returns the readings of a drive's servos at its shafts; `None` if a servo was never read.
    fn shafts(&self, drive: &BoardDrive, conditions: &[Condition]) -> Option<Shafts> {
        let mut shafts = Shafts { torques: Some(Numbers::new()), ..Shafts::default() };
        for index in &drive.servos {
            let index = usize::from(*index);
            let read = conditions.get(index)?.feedback?;
            let drive = self.servos.get(index)?;
            let servo = drive.servo();
            // There is room: a drive's number of servos is limited.
            let _ = shafts.positions.push(drive.shaft_position(read.position_rad));
            let _ = shafts.velocities.push(servo.shaft_velocity(read.velocity_rad_s));
            match (&mut shafts.torques, read.effort) {
                (Some(torques), Effort::Current(a)) => {
                    let own_nm = a * servo.settings().torque_constant_nm_a;
                    let _ = torques.push(servo.shaft_torque(own_nm));
                }
                (torques, _) => *torques = None,
            }
            shafts.age_ticks = shafts.age_ticks.max(read.age_ticks);
        }
        Some(shafts)
    }
}

/// Readings of a drive's servos, converted to the drive's shafts.
#[derive(Debug, Default)]
struct Shafts {
    positions: Numbers,
    velocities: Numbers,
    torques: Option<Numbers>,
    age_ticks: u32,
}

impl Shafts {
    fn to_joints(
        &self,
        drive: &BoardDrive,
        out: &mut [Option<Measured>],
    ) -> Result<(), DriveInputError> {
        let pose = drive.drive.at_servos(&self.positions)?;
        let velocities = pose.joint_velocities(&self.velocities)?;
        let efforts =
            self.torques.as_ref().map(|torques| pose.joint_efforts(torques)).transpose()?;
        for (place, dof) in drive.dofs.iter().enumerate().take(DRIVE_CAPACITY) {
            let at = |numbers: &[f32]| numbers.get(place).copied().unwrap_or(0.0);
            if let Some(out) = out.get_mut(usize::from(*dof)) {
                *out = Some(Measured {
                    position: at(pose.joints()),
                    velocity: at(&velocities),
                    effort: efforts.as_ref().map(|efforts| at(efforts)),
                    age_ticks: self.age_ticks,
                });
            }
        }
        Ok(())
    }
}
