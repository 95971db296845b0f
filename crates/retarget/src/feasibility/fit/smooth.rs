//! A low-pass of single joints, as far as the change is small.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::joint::{distance, normalize};
use crate::feasibility::low_pass::low_pass;
use crate::feasibility::rows::Rows;

/// Widths that are tried, s, about half an octave apart.
pub(super) const WIDTHS_S: [f64; 10] =
    [0.004, 0.006, 0.009, 0.013, 0.018, 0.025, 0.035, 0.05, 0.07, 0.1];
/// Maximum change of a slide, as a share of its range.
const MOST_OF_RANGE: f64 = 0.02;

/// Low-passes one joint of the `given` rows into `rows`, with a width of `sigma` rows, if the change is at most `most`
/// (rad or m), and for a slide at most a small share of its range. Returns the largest change; if the change would be
/// larger, leaves `rows` unchanged and returns `None`.
pub(super) fn smooth(
    mechanism: &Mechanism,
    joint: usize,
    given: &Rows,
    rows: &mut Rows,
    sigma: f64,
    most: f64,
) -> Option<f64> {
    let link = &mechanism.bodies[joint];
    let most = match (link.joint, link.ranges.first()) {
        (JointModel::Prismatic(_), Some([low, high])) => most.min(MOST_OF_RANGE * (high - low)),
        _ => most,
    };
    let numbers = mechanism.coordinate_ranges()[joint].clone();
    let columns: Vec<Vec<f64>> =
        numbers.clone().map(|k| low_pass(&given.column(k), sigma)).collect();
    let mut place = vec![0.0; numbers.len()];
    let smoothed = |row: usize, place: &mut [f64]| {
        for (place, column) in place.iter_mut().zip(&columns) {
            *place = column[row];
        }
        normalize(place);
    };
    let mut change = 0.0;
    for row in 0..given.count {
        smoothed(row, &mut place);
        change = f64::max(change, distance(&place, &given.row(row)[numbers.clone()]));
        if change > most {
            return None;
        }
    }
    for index in 0..given.count {
        smoothed(index, &mut rows.row_mut(index)[numbers.clone()]);
    }
    Some(change)
}
