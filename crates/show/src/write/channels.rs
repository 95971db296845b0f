//! Converts joints to channels.

use super::curve::Samples;
use super::refine::Bound;
use super::settings::Settings;
use crate::joint::Joint;

/// Returns the curves of a joint in groups that share an error bound: four curves of a rotation, or one.
pub(super) fn groups(
    joint: Joint,
    mut columns: Vec<Vec<f64>>,
    is_loop: bool,
    settings: &Settings,
) -> Vec<(Vec<Samples>, Bound)> {
    let mut groups = Vec::new();
    let samples = |values, flips| Samples { values, is_loop, flips };
    if joint.turns_freely() {
        let rest = columns.split_off(4);
        let flips = unwind(&mut columns);
        let group = columns.into_iter().map(|values| samples(values, flips)).collect();
        groups.push((group, Bound::Rotation(settings.angle_rad)));
        columns = rest;
    }
    let bound = match joint {
        Joint::Prismatic | Joint::Free => settings.length_m,
        _ => settings.angle_rad,
    };
    groups.extend(
        columns.into_iter().map(|values| (vec![samples(values, false)], Bound::Number(bound))),
    );
    groups
}

/// Normalises quaternions, and chooses the sign of each so that it is near its predecessor. Returns `true` if the first
/// quaternion would follow the last with the opposite sign.
fn unwind(columns: &mut [Vec<f64>]) -> bool {
    let mut last: Option<Vec<f64>> = None;
    let count = columns.first().map_or(0, Vec::len);
    for sample in 0..count {
        let q: Vec<f64> = columns.iter().map(|column| column[sample]).collect();
        let length = libm::sqrt(q.iter().map(|x| x * x).sum());
        let along = last.as_ref().map_or(1.0, |last| last.iter().zip(&q).map(|(a, b)| a * b).sum());
        let factor = if along < 0.0 { -1.0 / length } else { 1.0 / length };
        for (column, x) in columns.iter_mut().zip(&q) {
            column[sample] = x * factor;
        }
        last = Some(q.iter().map(|x| x * factor).collect());
    }
    let along: f64 = columns.iter().map(|column| column[0] * column[count - 1]).sum();
    along < 0.0
}
