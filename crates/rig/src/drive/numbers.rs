//! Lists of numbers for dofs and servos, and checks of them.

use heapless::Vec;

use super::error::{DriveError, DriveInputError};

/// Maximum number of dofs, and of servos, of a drive.
pub const DRIVE_CAPACITY: usize = 6;

/// One number for each dof, or for each servo, of a drive.
pub type Numbers = Vec<f32, DRIVE_CAPACITY>;

/// Largest accepted number, equal to that of `sinew-core`'s coordinates.
pub(super) const LARGEST: f32 = 1e6;

/// Minimum motion of a joint per radian of the servo, rad/rad or m/rad. A servo that causes less motion is regarded
/// as not moving the joint.
pub(super) const LEAST_MOTION: f32 = 1e-6;

/// Checks the count of numbers, and that each is finite and at most `LARGEST`.
pub(super) fn check(
    what: &'static str,
    expected: usize,
    numbers: &[f32],
) -> Result<(), DriveInputError> {
    if numbers.len() != expected {
        return Err(DriveInputError::Count { what, expected, found: numbers.len() });
    }
    // NaN is not in the range either.
    match numbers.iter().position(|number| !(-LARGEST..=LARGEST).contains(number)) {
        None => Ok(()),
        Some(index) => {
            let found = numbers.get(index).copied().unwrap_or(f32::NAN);
            Err(DriveInputError::Number { what, index, found })
        }
    }
}

/// Checks that a number of a drive's description is between two bounds. Refuses NaN.
pub(super) fn bounded(
    what: &'static str,
    index: usize,
    found: f32,
    [least, most]: [f32; 2],
) -> Result<f32, DriveError> {
    if (least..=most).contains(&found) {
        Ok(found)
    } else {
        Err(DriveError::Number { what, index, found, least, most })
    }
}

/// Collects the numbers that fit. The callers have checked the count, therefore all fit; `Iterator::collect` would
/// need a panic.
pub(super) fn collect<const N: usize>(numbers: impl IntoIterator<Item = f32>) -> Vec<f32, N> {
    let mut all = Vec::new();
    for number in numbers {
        if all.push(number).is_err() {
            break;
        }
    }
    all
}

pub(super) fn dot(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Maximum number of elements of a matrix: 4 x 4 and 1 x 6 fit, 6 x 6 does not.
pub const MATRIX_CAPACITY: usize = 16;
