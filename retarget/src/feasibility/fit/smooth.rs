//! A low-pass of single joints, as far as that changes little.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::Freedom;

use super::joint::{distance, normalize};
use crate::feasibility::low_pass::low_pass;

/// Widths that are tried, s: a third of an octave from one to the next.
pub(super) const WIDTHS_S: [f64; 10] =
    [0.004, 0.006, 0.009, 0.013, 0.018, 0.025, 0.035, 0.05, 0.07, 0.1];
/// The most of its range that a slide is changed by.
const MOST_OF_RANGE: f64 = 0.02;

/// Low-passes one joint of `given` rows into `rows`, `sigma` rows wide, if that changes it by at most `most` rad, or a
/// small part of a slide's range; returns the largest change.
pub(super) fn smooth(
    mechanism: &Mechanism,
    joint: usize,
    given: &[Vec<f64>],
    rows: &mut [Vec<f64>],
    sigma: f64,
    most: f64,
) -> Option<f64> {
    let link = &mechanism.bodies[joint];
    let most = match (link.joint, link.ranges.first()) {
        (Freedom::Prismatic(_), Some([low, high])) => most.min(MOST_OF_RANGE * (high - low)),
        _ => most,
    };
    let numbers = mechanism.coordinate_ranges()[joint].clone();
    let columns: Vec<Vec<f64>> = numbers
        .clone()
        .map(|k| low_pass(&given.iter().map(|row| row[k]).collect::<Vec<_>>(), sigma))
        .collect();
    let smoothed = |row: usize| -> Vec<f64> {
        let mut place: Vec<f64> = columns.iter().map(|column| column[row]).collect();
        normalize(&mut place);
        place
    };
    let changes = given
        .iter()
        .enumerate()
        .map(|(row, given)| distance(&smoothed(row), &given[numbers.clone()]));
    let change = changes.fold(0.0, f64::max);
    if change > most {
        return None;
    }
    for (index, row) in rows.iter_mut().enumerate() {
        row[numbers.clone()].copy_from_slice(&smoothed(index));
    }
    Some(change)
}
