//! Numbers of dofs and servos, their bounds, and small sums of them.

use heapless::Vec;

use super::error::{DriveError, DriveInputError};

/// The most dofs of a drive, and the most servos.
pub const DRIVE_CAPACITY: usize = 6;

/// One number for each dof, or for each servo, of a drive.
pub type Numbers = Vec<f32, DRIVE_CAPACITY>;

/// The largest number that a drive takes, as in `sinew-core`'s coordinates.
pub(super) const LARGEST: f32 = 1e6;

/// What moves a joint less than this, per radian of the servo, does not move it: rad/rad, or m/rad.
pub(super) const LEAST_MOTION: f32 = 1e-6;

/// Refuses what is not one proper number for each.
pub(super) fn check(
    what: &'static str,
    expected: usize,
    numbers: &[f32],
) -> Result<(), DriveInputError> {
    if numbers.len() != expected {
        return Err(DriveInputError::Count { what, expected, found: numbers.len() });
    }
    // NaN is not within.
    match numbers.iter().position(|number| !(-LARGEST..=LARGEST).contains(number)) {
        None => Ok(()),
        Some(index) => {
            let found = numbers.get(index).copied().unwrap_or(f32::NAN);
            Err(DriveInputError::Number { what, index, found })
        }
    }
}

/// A number of a drive's description, between bounds. NaN is refused.
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

/// The numbers that fit, in their order: all, since they were counted. `collect` cannot know that, and would panic.
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

/// The most numbers of a matrix: a drive may be 4 x 4, or 1 x 6, but not 6 x 6.
pub const MATRIX_CAPACITY: usize = 16;
