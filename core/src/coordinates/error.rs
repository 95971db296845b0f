//! Why coordinates of a tree were refused, and the checks of counts and numbers.

use core::fmt;
use core::iter::repeat_n;

use crate::joint::JointKind;
use crate::state::StateInputError;
use crate::tree::Body;

/// The largest position, speed, acceleration or effort that is accepted: no machine has more, and nothing that follows
/// from such numbers overflows.
const LARGEST: f32 = 1e6;

/// Why the coordinates of a tree's joints were refused.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
#[non_exhaustive]
pub enum CoordinatesError {
    /// A slice has too few or too many items for the tree.
    Count {
        /// Which slice.
        name: &'static str,
        /// How many items the tree asks for.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A number is NaN, or not from -1e6 to 1e6.
    Number {
        /// Which slice.
        name: &'static str,
        /// The joint that the number belongs to.
        joint: usize,
        /// Where in the slice.
        index: usize,
        /// The number.
        value: f32,
    },
    /// A joint's quaternion is not of length 1.
    NotUnit {
        /// The joint.
        joint: usize,
        /// Where in `q` the quaternion begins.
        index: usize,
        /// Its squared length.
        squared: f32,
    },
    /// There is no difference from the positions before: the time is not a positive number (from 1e-9 s), or a joint is
    /// farther than 1e6 m from its parent.
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

/// Refuses a slice of another length.
pub(super) fn check_count(
    name: &'static str,
    expected: usize,
    found: usize,
) -> Result<(), CoordinatesError> {
    if found == expected { Ok(()) } else { Err(CoordinatesError::Count { name, expected, found }) }
}

/// Refuses numbers that are too few, too many, no numbers or too large. `count`: how many a joint has.
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
