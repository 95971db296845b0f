//! A drive at one position, with its conversions of velocities, efforts and inertias.

use super::error::DriveInputError;
use super::matrix::Matrix;
use super::numbers::{DRIVE_CAPACITY, Numbers, check, collect};
use super::rotation_vector::RightJacobian;
use crate::limited::LimitReason;

/// A drive at one position. Its conversions are linear and conserve power.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivePose<'d> {
    pub(super) joints: Numbers,
    pub(super) servos: Numbers,
    pub(super) reason: Option<LimitReason>,
    pub(super) tangent: Tangent<'d>,
}

/// Relation between small motions of servos and joints.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Tangent<'d> {
    /// Linear: `q̇ = G ṡ`.
    Matrix(&'d Matrix),
    /// Ball joint: `ω = J G ṡ`, with the right Jacobian of the rotation vector.
    Ball(&'d Matrix, RightJacobian),
    /// One dof: `q̇ = slope ṡ`.
    Slope(f32),
}

impl DrivePose<'_> {
    /// Returns the positions of the joints, rad or m; for a ball joint the rotation vector.
    pub fn joints(&self) -> &[f32] {
        &self.joints
    }

    /// Returns the positions of the servos' shafts, rad.
    pub fn servos(&self) -> &[f32] {
        &self.servos
    }

    /// Returns [`LimitReason::Range`] if the requested position is beyond an end of the range and the pose is held
    /// at that end. For a ball joint the range ends at 180 deg.
    pub fn reason(&self) -> Option<LimitReason> {
        self.reason
    }

    /// Converts velocities of the joints' dofs to velocities of the servos' shafts, rad/s.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
    pub fn servo_velocities(&self, qd: &[f32]) -> Result<Numbers, DriveInputError> {
        check("joint velocities", self.joints.len(), qd)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.servos_of(qd),
            Tangent::Ball(matrix, jacobian) => matrix.servos_of(&jacobian.rates_of(qd)),
            Tangent::Slope(slope) => collect(qd.iter().map(|qd| qd / slope)),
        })
    }

    /// Converts velocities of the servos' shafts, rad/s, to velocities of the joints' dofs.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
    pub fn joint_velocities(&self, sd: &[f32]) -> Result<Numbers, DriveInputError> {
        check("servo velocities", self.servos.len(), sd)?;
        Ok(match &self.tangent {
            Tangent::Matrix(matrix) => matrix.joints_of(sd),
            Tangent::Ball(matrix, jacobian) => jacobian.velocities_of(&matrix.joints_of(sd)),
            Tangent::Slope(slope) => collect(sd.iter().map(|sd| sd * slope)),
        })
    }

    /// Converts efforts at the joints' dofs (N m or N) to torques of the servos' shafts, N m, by virtual work.
    /// Servos that share a joint share its effort such that the sum of squared torques is minimal.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
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

    /// Converts torques of the servos' shafts (N m) to efforts at the joints' dofs, N m or N. The result is not unique
    /// for mimic joints that share a servo; the function then returns one of the results that do the same work.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
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

    /// Converts inertias of the servos' rotors at their shafts (kg m²) to the inertia that they add to each dof, kg
    /// m² or kg. Viscous friction is converted in the same way.
    ///
    /// The result is the diagonal of `G⁺ᵀ J G⁺`. It leaves out the coupling of dofs through unequal servos, which a
    /// joint's own inertia cannot represent. If there are more dofs than servos (mimic joints), the dofs cannot
    /// move independently; the coupling is then added to each dof, so that the kinetic energy for a motion of one
    /// servo is correct.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
    pub fn reflected_to_joints(&self, per_servo: &[f32]) -> Result<Numbers, DriveInputError> {
        check("rotor inertias", self.servos.len(), per_servo)?;
        // Motion of each servo for a unit motion of each dof, and how far each dof follows its servos.
        let mut motions = heapless::Vec::<Numbers, DRIVE_CAPACITY>::new();
        for dof in 0..self.joints.len() {
            // There is room, because the number of dofs is checked.
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
