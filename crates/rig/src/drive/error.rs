//! Reasons why a drive is invalid, or refuses its input.

use core::fmt;

/// The reason why a drive is invalid.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DriveError {
    /// The number of items exceeds the capacity of a drive.
    TooMany {
        /// Kind of item: `"dofs"`, `"servos"`, `"numbers"` of a matrix, or `"points"` of a curve.
        what: &'static str,
        /// Number of items that were found.
        found: usize,
        /// Capacity of a drive.
        most: usize,
    },
    /// A drive needs more items.
    TooFew {
        /// Kind of item.
        what: &'static str,
        /// Number of items that were found.
        found: usize,
        /// Minimum number of items.
        least: usize,
    },
    /// A row of the matrix, or the list of offsets, has the wrong length.
    Length {
        /// List of the wrong length: `"row"` or `"offset"`.
        what: &'static str,
        /// Index of the row.
        index: usize,
        /// Length that was found.
        found: usize,
        /// Expected length.
        expected: usize,
    },
    /// A number is NaN, infinite or out of its range.
    Number {
        /// Name of the number.
        what: &'static str,
        /// Index in its list.
        index: usize,
        /// Number that was found.
        found: f32,
        /// Minimum accepted value.
        least: f32,
        /// Maximum accepted value.
        most: f32,
    },
    /// No servo moves a dof: all numbers of its row, or the mean slope of a curve, are below 1e-6 in absolute value.
    Unmoved {
        /// Index of the dof.
        dof: usize,
        /// Largest absolute value in its row, or of the mean slope.
        largest: f32,
    },
    /// A servo moves nothing: all numbers of its column are below 1e-6 in absolute value.
    Idle {
        /// Index of the servo.
        servo: usize,
        /// Largest absolute value in its column.
        largest: f32,
    },
    /// The matrix is nearly singular: in some direction the servos hardly move the joints.
    Singular {
        /// Condition number, with each row scaled to length 1; infinite for a singular matrix.
        condition: f32,
        /// Maximum accepted condition number.
        most: f32,
    },
    /// The servo positions of a curve do not rise.
    NotRising {
        /// Index of the first point that is not beyond its predecessor.
        point: usize,
    },
    /// The joint positions of a curve change direction.
    NotMonotone {
        /// Index of the point where they change direction.
        point: usize,
    },
    /// A curve is too flat: somewhere the servo hardly moves the joint.
    Flat {
        /// Minimum slope, as a share of the curve's mean slope.
        share: f32,
        /// Minimum accepted share.
        least: f32,
    },
    /// At some servo position within the range, the links of a four-bar are too short or too long to be connected.
    Open {
        /// Servo position where they cannot be connected, rad.
        servo_rad: f32,
    },
    /// Rod and lever of a four-bar come too close to a line: the servo cannot hold the joint there.
    Transmission {
        /// Servo position where they are closest to a line, rad.
        servo_rad: f32,
        /// Angle between them there, rad.
        found_rad: f32,
        /// Minimum accepted angle, rad.
        least_rad: f32,
    },
    /// Crank and rod of a four-bar come too close to a line, a toggle: there the servo hardly moves the joint, or
    /// the joint reverses.
    Toggle {
        /// Servo position where they are closest to a line, rad.
        servo_rad: f32,
        /// Angle between them there, rad.
        found_rad: f32,
        /// Minimum accepted angle, rad.
        least_rad: f32,
    },
    /// The rocker of a four-bar turns by more than 180 deg from its zero.
    RockerWraps,
    /// A ball joint needs a matrix of three rows and at least three columns.
    Ball {
        /// Number of rows.
        dofs: usize,
        /// Number of columns.
        servos: usize,
    },
}

impl fmt::Display for DriveError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::TooMany { what, found, most } => {
                write!(f, "the drive has {found} {what}; it holds {most}")
            }
            Self::TooFew { what, found, least } => {
                write!(f, "the drive has {found} {what}; it needs at least {least}")
            }
            Self::Length { what, index, found, expected } => {
                write!(f, "{what} {index} has {found} numbers; it must have {expected}")
            }
            Self::Number { what, index, found, least, most } => {
                write!(f, "{what} {index} is {found}; it must be a number from {least} to {most}")
            }
            Self::Unmoved { dof, largest } => write!(
                f,
                "no servo moves dof {dof}: the largest number of its row is {largest}; \
                 it must be at least 1e-6 in size"
            ),
            Self::Idle { servo, largest } => write!(
                f,
                "servo {servo} moves no joint: the largest number of its column is {largest}; \
                 it must be at least 1e-6 in size"
            ),
            Self::Singular { condition, most } => write!(
                f,
                "the matrix is singular or near it: its condition number is {condition}; \
                 it must be at most {most}"
            ),
            Self::NotRising { point } => write!(
                f,
                "point {point} of the curve is not beyond the one before; servo positions must rise"
            ),
            Self::NotMonotone { point } => write!(
                f,
                "the curve turns back at point {point}; joint positions must all rise or all fall"
            ),
            Self::Flat { share, least } => write!(
                f,
                "the curve has a slope of {share} of its mean slope; it must be at least {least}"
            ),
            Self::Open { servo_rad } => write!(
                f,
                "the links do not close at {:.1} deg of the servo; check their lengths, or its range",
                servo_rad.to_degrees()
            ),
            Self::Transmission { servo_rad, found_rad, least_rad } => write!(
                f,
                "rod and lever are {:.1} deg from one line at {:.1} deg of the servo; \
                 it must be at least {:.0} deg",
                found_rad.to_degrees(),
                servo_rad.to_degrees(),
                least_rad.to_degrees()
            ),
            Self::Toggle { servo_rad, found_rad, least_rad } => write!(
                f,
                "crank and rod are {:.1} deg from one line, a toggle, at {:.1} deg of the servo; \
                 it must be at least {:.0} deg",
                found_rad.to_degrees(),
                servo_rad.to_degrees(),
                least_rad.to_degrees()
            ),
            Self::RockerWraps => f.write_str(
                "the rocker passes half a turn from its zero; set its zero near the middle of its range",
            ),
            Self::Ball { dofs, servos } => write!(
                f,
                "the matrix is {dofs} x {servos}; a ball joint needs three rows and at least three columns"
            ),
        }
    }
}

impl core::error::Error for DriveError {}

/// The reason why a drive refuses its input.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DriveInputError {
    /// The count is not one number for each dof, or for each servo.
    Count {
        /// Name of the numbers.
        what: &'static str,
        /// Expected count.
        expected: usize,
        /// Count that was found.
        found: usize,
    },
    /// A number is NaN, infinite, or above 1e6 in absolute value.
    Number {
        /// Name of the numbers.
        what: &'static str,
        /// Index of the number.
        index: usize,
        /// Number that was found.
        found: f32,
    },
}

impl fmt::Display for DriveInputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Count { what, expected, found } => {
                write!(f, "the drive takes {expected} {what}, not {found}")
            }
            Self::Number { what, index, found } => {
                write!(f, "{what} {index} is {found}; it must be a number from -1e6 to 1e6")
            }
        }
    }
}

impl core::error::Error for DriveInputError {}
