//! Errors in the coordinates of a tree, and the checks of counts and numbers.

use core::fmt;
use core::iter::repeat_n;

use crate::joint::JointKind;
use crate::state::StateInputError;
use crate::tree::Body;

/// Maximum absolute position, speed, acceleration or effort. No machine exceeds it, and products of such numbers stay
/// far below the largest f32.
const LARGEST: f32 = 1e6;

/// An error in the coordinates of a tree's joints.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CoordinatesError {
    /// A slice has too few or too many items for the tree.
    Count {
        /// Name of the slice.
        name: &'static str,
        /// Number of items that the tree needs.
        expected: usize,
        /// Number of items in the slice.
        found: usize,
    },
    /// A number is NaN, or not from -1e6 to 1e6.
    Number {
        /// Name of the slice.
        name: &'static str,
        /// Index of the joint that the number belongs to.
        joint: usize,
        /// Index in the slice.
        index: usize,
        /// The invalid number.
        value: f32,
    },
    /// A joint's quaternion is not of length 1.
    NotUnit {
        /// Index of the joint.
        joint: usize,
        /// Index in `q` of the quaternion's first component.
        index: usize,
        /// Squared length of the quaternion.
        squared: f32,
    },
    /// The difference from the previous positions does not exist: the time is not a positive number (at least 1e-9
    /// s), or a joint is farther than 1e6 m from its parent.
    Difference(StateInputError),
}

impl fmt::Display for CoordinatesError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Count { name, expected, found } => {
                write!(f, "{name} must have {expected} items for this tree, not {found}")
            }
            Self::Number { name, joint, index, value } => write!(
                f,
                "{name}[{index}], of joint {joint}, is {value}; it must be a number from -1e6 to 1e6"
            ),
            Self::NotUnit { joint, index, squared } => write!(
                f,
                "the quaternion from q[{index}] on, of joint {joint}, has squared length {squared}; it must be a unit quaternion"
            ),
            Self::Difference(error) => write!(f, "speeds by differences: {error}"),
        }
    }
}

impl core::error::Error for CoordinatesError {}

/// Refuses a slice whose length is not `expected`.
pub(super) fn check_count(
    name: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), CoordinatesError> {
    if found == expected { Ok(()) } else { Err(CoordinatesError::Count { name, expected, found }) }
}

/// Refuses a slice of the wrong length, and numbers that are NaN or too large. `count` returns the number of
/// numbers for each joint.
pub(super) fn check_numbers(
    name: &'static str,
    bodies: &[Body],
    count: impl Fn(JointKind) -> usize + Copy,
    numbers: &[f32],
) -> Result<(), CoordinatesError> {
    let counts = || bodies.iter().map(|body| count(body.joint));
    check_count(name, counts().fold(0, usize::saturating_add), numbers.len())?;
    // Written so that NaN fails.
    let usable = |value: &f32| value.abs() <= LARGEST;
    let Some(index) = numbers.iter().position(|value| !usable(value)) else { return Ok(()) };
    let mut joints = counts().enumerate().flat_map(|(joint, count)| repeat_n(joint, count));
    let joint = joints.nth(index).unwrap_or_default();
    let value = numbers.get(index).copied().unwrap_or_default();
    Err(CoordinatesError::Number { name, joint, index, value })
}
