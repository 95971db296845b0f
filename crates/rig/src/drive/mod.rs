//! Drives convert positions, velocities and efforts of joints to those of servos, and back.
//!
//! Servo positions here are those of the drive's input shafts, rad; [`Servo`](crate::servo::Servo) converts them to
//! the servo's own positions. For a ball joint, `q` is the rotation vector of the body in the joint frame;
//! velocities and efforts are in body axes, as in `sinew-core`.
//!
//! A [`DrivePose`] is a drive at one position. Its conversions of velocities and efforts conserve power.
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
//! # Refused drives
//! A drive is refused if it is nearly singular anywhere in its range. If a servo hardly moves its joint, small
//! position errors cause large motions of the servo; if rod and lever are in line, the servo cannot hold the joint.
//! Real transmissions stay far from both, therefore such numbers are a mistake in the file:
//! - a [`Matrix`] with a condition number above 100 (see there);
//! - a [`Curve`] with a slope below 1/100 of its mean;
//! - a [`FourBar`] whose links come closer to a line than 5 deg.

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

/// A relation between the positions of servos and joints.
#[derive(Debug, Clone, PartialEq)]
pub enum Drive {
    /// Linear: one to one, mirrored, mimic, differential, or three servos of a ball joint.
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
    /// Returns the number of dofs that the drive moves.
    pub fn dofs(&self) -> usize {
        match self {
            Self::Matrix(matrix) => matrix.dofs(),
            Self::Curve(_) | Self::FourBar(_) => 1,
        }
    }

    /// Returns the number of servos.
    pub fn servos(&self) -> usize {
        match self {
            Self::Matrix(matrix) => matrix.servos(),
            Self::Curve(_) | Self::FourBar(_) => 1,
        }
    }

    /// Returns the drive at joint positions `q`, rad or m. Beyond the ends of a curve or a four-bar the drive is
    /// held at the end, and [`DrivePose::reason`] reports this.
    ///
    /// With fewer servos than dofs (mimic joints), the servos may be unable to reach `q`. The result then minimizes
    /// the sum of squared errors, each divided by the length of the dof's row.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each dof, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
    pub fn at_joints(&self, q: &[f32]) -> Result<DrivePose<'_>, DriveInputError> {
        check("joint positions", self.dofs(), q)?;
        Ok(match (self, q) {
            (Self::Matrix(matrix), _) => matrix.at_joints(q),
            (Self::Curve(curve), &[q, ..]) => curve.at_joint(q),
            (Self::FourBar(four_bar), &[q, ..]) => four_bar.at_joint(q),
            // Not reached: the count was checked above.
            (Self::Curve(_) | Self::FourBar(_), []) => return Err(none_of("joint positions")),
        })
    }

    /// Returns the drive at servo shaft positions `s`, rad. Beyond the ends of a curve or a four-bar the drive is
    /// held at the end, and [`DrivePose::reason`] reports this.
    ///
    /// # Errors
    /// [`DriveInputError`] if there is not one number for each servo, or a number is NaN, infinite or above 1e6 in
    /// absolute value.
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
