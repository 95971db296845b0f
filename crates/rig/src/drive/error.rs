//! Why a drive cannot be, and what it cannot be asked.

use core::fmt;

/// Why a drive was refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DriveError {
    /// More of something than a drive holds.
    TooMany {
        /// The kind of item: `"dofs"`, `"servos"`, `"numbers"` of a matrix, or `"points"` of a curve.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many it holds.
        most: usize,
    },
    /// Fewer of something than a drive needs.
    TooFew {
        /// Of what.
        what: &'static str,
        /// How many there are.
        found: usize,
        /// How many it needs.
        least: usize,
    },
    /// A row of the matrix, or the offsets, are not of the right length.
    Length {
        /// `"row"` or `"offset"`.
        what: &'static str,
        /// Which row.
        index: usize,
        /// How many numbers it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// A number is NaN, infinite or beyond what it may be.
    Number {
        /// Which number.
        what: &'static str,
        /// Its place, of a list.
        index: usize,
        /// The number.
        found: f32,
        /// The least that it may be.
        least: f32,
        /// The most that it may be.
        most: f32,
    },
    /// A row of the matrix has no number of at least 1e-6 in size: no servo moves that dof.
    Unmoved {
        /// The dof.
        dof: usize,
        /// The largest number of its row, in size.
        largest: f32,
    },
    /// A column of the matrix has no number of at least 1e-6 in size: that servo moves nothing.
    Idle {
        /// The servo.
        servo: usize,
        /// The largest number of its column, in size.
        largest: f32,
    },
    /// The matrix is singular, or near it: in some direction the servos hardly move the joints.
    Singular {
        /// Its condition number, each row scaled to length 1; infinite if it is singular.
        condition: f32,
        /// The largest that is accepted.
        most: f32,
    },
    /// The abscissas of a curve do not rise.
    NotRising {
        /// The first point that is not beyond the one before.
        point: usize,
    },
    /// A curve turns back.
    NotMonotone {
        /// The point where it does.
        point: usize,
    },
    /// A curve has a place where the servo hardly moves the joint.
    Flat {
        /// Least slope, as a share of the curve's mean slope.
        share: f32,
        /// The least share that is accepted.
        least: f32,
    },
    /// The links of a four-bar do not close everywhere in the servo's range.
    Open {
        /// Servo position where they do not, rad.
        servo_rad: f32,
    },
    /// Rod and lever of a four-bar come too near one line: the servo cannot hold the joint.
    Transmission {
        /// Servo position where they are nearest to it, rad.
        servo_rad: f32,
        /// The angle between them there, rad.
        found_rad: f32,
        /// The least that is accepted, rad.
        least_rad: f32,
    },
    /// Crank and rod of a four-bar come too near one line, a toggle: the servo hardly moves the joint, or turns back.
    Toggle {
        /// Servo position where they are nearest to it, rad.
        servo_rad: f32,
        /// The angle between them there, rad.
        found_rad: f32,
        /// The least that is accepted, rad.
        least_rad: f32,
    },
    /// The rocker of a four-bar passes half a turn from its zero.
    RockerWraps,
    /// A ball joint needs a matrix of three rows and at least three columns.
    Ball {
        /// Rows.
        dofs: usize,
        /// Columns.
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

/// Numbers that a drive does not take.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum DriveInputError {
    /// Not one number for each dof, or for each servo.
    Count {
        /// What the numbers are.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A number is NaN, infinite or larger than 1e6 in size.
    Number {
        /// What the numbers are.
        what: &'static str,
        /// Its place.
        index: usize,
        /// The number.
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
