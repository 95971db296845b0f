//! Drives: how servos move joints. Positions, velocities and efforts of joints to those of servos, and back.
//!
//! Servo positions here are those of the shafts that a drive sees, rad; [`Servo`](crate::servo::Servo) turns them into
//! the servo's own. Of a ball joint, `q` is the rotation vector of the body in the joint frame, velocities and efforts
//! are in body axes, as in `sinew-core`.
//!
//! A [`DrivePose`] is a drive at one position. Its maps of velocities and efforts belong together: the power is the
//! same on both sides.
//!
//! ```
//! use sinew_rig::drive::{Drive, Matrix};
//! // Two servos turn a wrist through a differential: together they bend it, against each other they roll it.
//! let wrist = Drive::from(Matrix::new(&[[0.5, 0.5], [0.5, -0.5]], &[])?);
//! let pose = wrist.at_joints(&[0.3, 0.1])?;
//! let [left, right] = pose.servos() else { unreachable!("it has two") };
//! assert!((left - 0.4).abs() < 1e-6 && (right - 0.2).abs() < 1e-6);
//! assert_eq!(pose.servo_torques(&[2.0, 0.0])?, [1.0, 1.0]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # What is refused
//! A drive that is singular, or nearly so, somewhere in its range. Where a servo hardly moves its joint, small errors
//! of position become large motions of the servo; where rod and lever are in line, the servo cannot hold the joint.
//! Real transmissions stay far from both; what is refused is a mistake in the file:
//! - a [`Matrix`] of a condition number above 100 (see there);
//! - a [`Curve`] with a slope below 1/100 of its mean;
//! - a [`FourBar`] whose links come nearer to one line than 5 degrees.

#![warn(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::indexing_slicing,
    clippy::missing_errors_doc,
    clippy::arithmetic_side_effects
)]

mod curve;
mod error;
mod four_bar;
mod friction;
mod matrix;
mod matrix_pose;
mod numbers;
mod pose;
mod pseudo_inverse;
mod rotation_vector;

pub use curve::{CURVE_CAPACITY, Curve};
pub use error::{DriveError, DriveInputError};
pub use four_bar::{FourBar, Links};
pub use friction::{FULL_SPEED, Friction};
pub use matrix::Matrix;
pub use numbers::{DRIVE_CAPACITY, MATRIX_CAPACITY, Numbers};
pub use pose::DrivePose;

use numbers::check;

/// How servos move joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// Linear: one to one, mirrored, mimic, differential, three servos of a ball joint.
    Matrix(Matrix),
    /// One servo and one joint, by a monotone curve.
    Curve(Curve),
    /// One servo and one joint, by a four-bar linkage.
    FourBar(FourBar),
}

impl From<Matrix> for Drive {
    fn from(matrix: Matrix) -> Self {
        Self::Matrix(matrix)
    }
}

impl From<Curve> for Drive {
    fn from(curve: Curve) -> Self {
        Self::Curve(curve)
    }
}

impl From<FourBar> for Drive {
    fn from(four_bar: FourBar) -> Self {
        Self::FourBar(four_bar)
    }
}

impl Drive {
    /// How many dofs it moves.
    pub fn dofs(&self) -> usize {
        match self {
            Self::Matrix(matrix) => matrix.dofs(),
            Self::Curve(_) | Self::FourBar(_) => 1,
        }
    }

    /// How many servos it has.
    pub fn servos(&self) -> usize {
        match self {
            Self::Matrix(matrix) => matrix.servos(),
            Self::Curve(_) | Self::FourBar(_) => 1,
        }
    }

    /// The drive where the joints are at `q`, rad or m. Beyond the ends of a curve or a four-bar it is held at the end,
    /// and says so.
    ///
    /// With fewer servos than dofs (mimic joints), `q` may be out of what the servos can do: they then go where the
    /// squared errors, each as a share of its joint's row, are least together.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or one is NaN, infinite or above 1e6 in size.
    pub fn at_joints(&self, q: &[f32]) -> Result<DrivePose<'_>, DriveInputError> {
        check("joint positions", self.dofs(), q)?;
        Ok(match (self, q) {
            (Self::Matrix(matrix), _) => matrix.at_joints(q),
            (Self::Curve(curve), &[q, ..]) => curve.at_joint(q),
            (Self::FourBar(four_bar), &[q, ..]) => four_bar.at_joint(q),
            // One number was counted above.
            (Self::Curve(_) | Self::FourBar(_), []) => return Err(none_of("joint positions")),
        })
    }

    /// The drive where the servos' shafts are at `s`, rad. Beyond the ends of a curve or a four-bar it is held at the
    /// end, and says so.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or one is NaN, infinite or above 1e6 in size.
    pub fn at_servos(&self, s: &[f32]) -> Result<DrivePose<'_>, DriveInputError> {
        check("servo positions", self.servos(), s)?;
        Ok(match (self, s) {
            (Self::Matrix(matrix), _) => matrix.at_servos(s),
            (Self::Curve(curve), &[s, ..]) => curve.at_servo(s),
            (Self::FourBar(four_bar), &[s, ..]) => four_bar.at_servo(s),
            (Self::Curve(_) | Self::FourBar(_), []) => return Err(none_of("servo positions")),
        })
    }
}

fn none_of(what: &'static str) -> DriveInputError {
    DriveInputError::Count { what, expected: 1, found: 0 }
}
