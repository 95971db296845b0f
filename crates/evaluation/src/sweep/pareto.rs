//! Finds the cells of a sweep that are on the front of mean linear error over mean angular error.

use std::collections::BTreeMap;

use crate::pareto::on_front;
use crate::{ControllerSettings, Errors, Setup};

/// The Pareto front among cells of one task: the rig and its disturbances are equal, the controllers differ.
#[derive(Debug, Clone, PartialEq)]
pub struct ParetoFront {
    /// Number of compared cells.
    pub of: usize,
    /// Cells on the front with their errors, in increasing order of mean angular error.
    pub cells: Vec<(usize, Errors)>,
}

/// Returns the task of a setup as text: everything except its controller. Only rows of one task are comparable.
pub(super) fn task(setup: &Setup) -> String {
    let task = Setup { controller: ControllerSettings::default(), ..setup.clone() };
    task.to_toml()
}

/// Returns mean angular and mean linear error of all joints.
fn means(errors: &Errors) -> [f64; 2] {
    [errors.all.angular_mean_deg(), errors.all.linear_mean_cm()]
}

/// Returns, for each row, whether it is on the front of the rows with an equal key; `None` for a row without
/// errors.
pub(super) fn of_rows<K: Ord>(rows: &[(K, Option<Errors>)]) -> Vec<Option<bool>> {
    let mut groups: BTreeMap<&K, Vec<(usize, [f64; 2])>> = BTreeMap::new();
    for (row, (key, errors)) in rows.iter().enumerate() {
        if let Some(errors) = errors {
            groups.entry(key).or_default().push((row, means(errors)));
        }
    }
    let mut of_rows = vec![None; rows.len()];
    for group in groups.values() {
        let points: Vec<[f64; 2]> = group.iter().map(|(_, means)| *means).collect();
        for ((row, _), on_front) in group.iter().zip(on_front(&points)) {
            of_rows[*row] = Some(on_front);
        }
    }
    of_rows
}

/// Returns the fronts of all tasks with several cells, in the order of their first cells.
pub(super) fn fronts<'a>(
    cells: impl Iterator<Item = (usize, &'a Setup, Errors)>,
) -> Vec<ParetoFront> {
    let (indices, rows): (Vec<usize>, Vec<_>) =
        cells.map(|(cell, setup, errors)| (cell, (task(setup), Some(errors)))).unzip();
    let mut order: Vec<&str> = Vec::new();
    let mut fronts: BTreeMap<&str, ParetoFront> = BTreeMap::new();
    for ((cell, (task, errors)), on_front) in indices.iter().zip(&rows).zip(of_rows(&rows)) {
        let front = fronts.entry(task).or_insert_with(|| {
            order.push(task);
            ParetoFront { of: 0, cells: Vec::new() }
        });
        front.of += 1;
        if let (Some(errors), Some(true)) = (errors, on_front) {
            front.cells.push((*cell, *errors));
        }
    }
    let mut fronts: Vec<ParetoFront> =
        order.iter().filter_map(|task| fronts.remove(task)).collect();
    fronts.retain(|front| front.of > 1);
    for front in &mut fronts {
        front.cells.sort_by(|(_, a), (_, b)| means(a)[0].total_cmp(&means(b)[0]));
    }
    fronts
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::{ImportanceWeights, Rig};
    use sinew_figure::plant::Pose;
    use sinew_figure::{Dimensions, Root, fixture};

    fn errors(angle_rad: f64, distance_m: f64) -> Errors {
        let pose = |angle: f64, x: f64| Pose {
            rotation: DQuat::from_rotation_y(angle),
            position_m: DVec3::new(x, 0.0, 0.0),
        };
        let mut errors = Errors::default();
        let mechanism = fixture::mechanism();
        let weights = ImportanceWeights::zero(&mechanism);
        let rig = Rig::with_weights(mechanism, weights);
        let [desired, measured] =
            [pose(0.0, 0.0), pose(angle_rad, distance_m)].map(|pose| vec![pose; rig.links().len()]);
        errors.add(&desired, &measured, &rig);
        errors
    }

    #[test]
    fn cells_are_held_against_those_of_the_same_task_alone() {
        let of_scale = |scale| Setup { dimensions: Dimensions::uniform(scale), ..Setup::default() };
        let mut stiff = of_scale(1.1);
        stiff.controller.kp = 300.0;
        let mut bolted = of_scale(1.1);
        bolted.root = Root::Fixed;
        let setups = [&of_scale(1.0), &of_scale(1.1), &stiff, &stiff, &bolted];
        let cells = [(0.01, 0.01), (0.02, 0.04), (0.03, 0.05), (0.01, 0.06), (0.05, 0.08)];
        let cells = cells.map(|(angle, distance)| errors(angle, distance));
        let fronts =
            fronts((0..).zip(setups).zip(cells).map(|((cell, setup), e)| (cell, setup, e)));
        let [front] = &fronts[..] else { panic!("one task has several cells: {fronts:?}") };
        let on_front: Vec<usize> = front.cells.iter().map(|(cell, _)| *cell).collect();
        assert_eq!((front.of, on_front.as_slice()), (3, &[3, 1][..]));
    }

    #[test]
    fn a_lost_figure_is_on_no_front() {
        let rows = [("a", None), ("a", Some(errors(0.2, 0.2))), ("b", Some(errors(0.1, 0.1)))];
        assert_eq!(of_rows(&rows), [None, Some(true), Some(true)]);
    }
}
