//! A drive at one position: its maps of velocities, efforts and inertias.

use super::error::DriveInputError;
use super::matrix::Matrix;
use super::numbers::{DRIVE_CAPACITY, Numbers, check, collect};
use super::rotation_vector::RightJacobian;
use crate::limited::LimitReason;

/// A drive at one position. Its maps are linear, and the power is the same on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivePose<'d> {
    pub(super) joints: Numbers,
    pub(super) servos: Numbers,
    pub(super) reason: Option<LimitReason>,
    pub(super) tangent: Tangent<'d>,
}

/// How small motions of servos and joints belong together.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Tangent<'d> {
    /// `q̇ = G ṡ`.
    Matrix(&'d Matrix),
    /// `ω = J G ṡ`, with the right Jacobian of the rotation vector.
    Ball(&'d Matrix, RightJacobian),
    /// `q̇ = slope ṡ`.
    Slope(f32),
}

impl DrivePose<'_> {
    /// Positions of the joints: rad, m; of a ball joint the rotation vector.
    pub fn joints(&self) -> &[f32] {
        &self.joints
    }

    /// Positions of the servos' shafts, rad.
    pub fn servos(&self) -> &[f32] {
        &self.servos
    }

    /// [`LimitReason::Range`] if the position asked for is beyond an end, and this is the end; of a ball joint, if it
    /// is beyond half a turn.
    pub fn reason(&self) -> Option<LimitReason> {
        self.reason
    }

    /// Velocities of the servos' shafts, rad/s, at velocities of the joints' dofs.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or one is NaN, infinite or above 1e6 in size.
    pub fn servo_velocities(&self, qd: &[f32]) -> Result<Numbers, DriveInputError> {
        check("joint velocities", self.joints.len(), qd)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.servos_of(qd),
            Tangent::Ball(matrix, jacobian) => matrix.servos_of(&jacobian.rates_of(qd)),
            Tangent::Slope(slope) => collect(qd.iter().map(|qd| qd / slope)),
        })
    }

    /// Velocities of the joints' dofs at velocities of the servos' shafts, rad/s.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or one is NaN, infinite or above 1e6 in size.
    pub fn joint_velocities(&self, sd: &[f32]) -> Result<Numbers, DriveInputError> {
        check("servo velocities", self.servos.len(), sd)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.joints_of(sd),
            Tangent::Ball(matrix, jacobian) => jacobian.velocities_of(&matrix.joints_of(sd)),
            Tangent::Slope(slope) => collect(sd.iter().map(|sd| sd * slope)),
        })
    }

    /// Torques of the servos' shafts, N m, that give efforts at the joints' dofs, N m or N: by virtual work. Servos
    /// that share a joint share its effort so that the squares of their torques are least together.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or one is NaN, infinite or above 1e6 in size.
    pub fn servo_torques(&self, efforts: &[f32]) -> Result<Numbers, DriveInputError> {
        check("joint efforts", self.joints.len(), efforts)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.torques_of(efforts),
            Tangent::Ball(matrix, jacobian) => {
                matrix.torques_of(&jacobian.moments_of_rates(efforts))
            }
            Tangent::Slope(slope) => collect(efforts.iter().map(|effort| effort * slope)),
        })
    }

    /// Efforts at the joints' dofs, N m or N, of torques of the servos' shafts, N m. Of mimic joints, whose efforts
    /// one servo cannot tell apart, those that do the same work.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or one is NaN, infinite or above 1e6 in size.
    pub fn joint_efforts(&self, torques: &[f32]) -> Result<Numbers, DriveInputError> {
        check("servo torques", self.servos.len(), torques)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.efforts_of(torques),
            Tangent::Ball(matrix, jacobian) => {
                jacobian.moments_of_body(&matrix.efforts_of(torques))
            }
            Tangent::Slope(slope) => collect(torques.iter().map(|torque| torque / slope)),
        })
    }

    /// Returns the inertia that the servos' rotors, kg m² at their shafts, add to each dof, kg m² or kg.
    /// Viscous frictions of servos become those of joints in the same way.
    ///
    /// It is the diagonal of `G⁺ᵀ J G⁺`: what is left out, the coupling of dofs through unlike servos, has no place
    /// in a joint's own inertia. Dofs that outnumber their servos (mimic joints) cannot move apart, so that the
    /// coupling is added to each: then the kinetic energy of one servo is the true one.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or one is NaN, infinite or above 1e6 in size.
    pub fn reflected_to_joints(&self, per_servo: &[f32]) -> Result<Numbers, DriveInputError> {
        check("rotor inertias", self.servos.len(), per_servo)?;
        // Motion of each servo for a unit motion of each dof, and how far each dof goes with its servos.
        let mut motions = heapless::Vec::<Numbers, DRIVE_CAPACITY>::new();
        for dof in 0..self.joints.len() {
            // There is room: dofs are counted.
            let _ = motions.push(self.servo_velocities(&self.unit(dof))?);
        }
        let mimic = self.joints.len() > self.servos.len();
        let sizes = match &self.tangent {
            Tangent::Matrix(matrix) if mimic => matrix.row_lengths(),
            _ => collect(self.joints.iter().map(|_| 1.0)),
        };
        let energy = |a: &[f32], b: &[f32]| -> f32 {
            per_servo.iter().zip(a.iter().zip(b)).map(|(inertia, (a, b))| inertia * a * b).sum()
        };
        Ok(collect(motions.iter().zip(&sizes).enumerate().map(|(dof, (own, size))| {
            let others = motions.iter().zip(&sizes).enumerate().filter(|(other, _)| *other != dof);
            let coupling: f32 =
                others.map(|(_, (motion, far))| energy(own, motion).abs() * far / size).sum();
            energy(own, own) + if mimic { coupling } else { 0.0 }
        })))
    }

    fn unit(&self, dof: usize) -> Numbers {
        collect((0..self.joints.len()).map(|other| if other == dof { 1.0 } else { 0.0 }))
    }
}
