//! The fronts of a sweep: angle and distance of its methods and weights, task by task.

use std::collections::{BTreeMap, BTreeSet};

use sinew_evaluation::MethodName;
use sinew_evaluation::pareto::on_front;

use super::{Column, Sweep, distinct};
use crate::chart::{Joined, ParetoChart, Spot};

/// Columns of the distances that are shown over the angles of all joints.
const DISTANCES: [(&str, &str); 2] =
    [("all_linear_mean_cm", "all joints"), ("leaf_linear_mean_cm", "leaf joints")];

/// Maximum number of spots for which all are labelled. With more, only spots on the front are labelled.
const LABELLED: usize = 24;

/// The fronts of one task of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Fronts {
    /// Methods in the task.
    pub(crate) methods: Vec<MethodName>,
    /// Charts, one for each distance.
    pub(crate) charts: Vec<ParetoChart>,
}

/// Returns whether a parameter belongs to the controller, and not to the task.
fn is_control(parameter: &Column<String>) -> bool {
    parameter.name.starts_with("controller.")
}

impl Sweep {
    /// Returns the fronts of all tasks in which methods or controller settings vary, in the order of the cells.
    pub(crate) fn fronts(&self) -> Vec<Fronts> {
        let (controls, others): (Vec<_>, Vec<_>) =
            self.parameters.iter().partition(|p| is_control(p));
        let Some(angles) = self.metric("all_angular_mean_deg") else { return Vec::new() };
        if controls.is_empty() {
            return Vec::new();
        }
        let mut tasks: BTreeMap<Vec<&str>, Vec<usize>> = BTreeMap::new();
        for cell in 0..self.cells {
            let task = others.iter().map(|parameter| parameter.values[cell].as_str()).collect();
            tasks.entry(task).or_default().push(cell);
        }
        tasks.retain(|_, cells| cells.iter().filter(|cell| angles[**cell].is_some()).count() > 1);
        // The condition contains only the parameters that distinguish these tasks.
        let told: Vec<usize> = (0..others.len())
            .filter(|p| tasks.keys().map(|task| task[*p]).collect::<BTreeSet<_>>().len() > 1)
            .collect();
        let mut tasks: Vec<(&Vec<&str>, &Vec<usize>)> = tasks.iter().collect();
        tasks.sort_by_key(|(_, cells)| cells[0]);
        let fronts = tasks.into_iter().map(|(task, cells)| {
            let condition: Vec<String> =
                told.iter().map(|p| format!("{} {}", others[*p].name, task[*p])).collect();
            self.of_task(cells, &controls, &condition.join(", "))
        });
        fronts.collect()
    }

    fn metric(&self, name: &str) -> Option<&[Option<f64>]> {
        let column = self.metrics.iter().find(|metric| metric.name == name);
        column.map(|column| column.values.as_slice())
    }

    fn of_task(&self, cells: &[usize], controls: &[&Column<String>], condition: &str) -> Fronts {
        let mut methods: Vec<Option<MethodName>> = Vec::new();
        for cell in cells {
            if !methods.contains(&self.methods[*cell]) {
                methods.push(self.methods[*cell]);
            }
        }
        let of_methods: Vec<(Option<MethodName>, Series<'_>)> = methods
            .iter()
            .map(|method| {
                let own = cells.iter().copied().filter(|cell| self.methods[*cell] == *method);
                (*method, Series::new(own.collect(), controls))
            })
            .collect();
        let charts = DISTANCES.iter().filter_map(|(metric, name)| {
            let (angles, distances) = (self.metric("all_angular_mean_deg")?, self.metric(metric)?);
            let means = |cell: usize| Some([angles[cell]?, distances[cell]?]);
            let (mut spots, mut joined) = (Vec::new(), Vec::new());
            for (method, series) in &of_methods {
                let found = series.cells.iter().filter_map(|cell| Some((*cell, means(*cell)?)));
                let own: Vec<Spot> =
                    found.map(|(cell, means)| series.spot(cell, *method, means)).collect();
                if series.is_line() {
                    let means = own.iter().map(|spot| spot.means).collect();
                    joined.push(Joined { method: *method, means });
                }
                spots.extend(own);
            }
            let points: Vec<[f64; 2]> = spots.iter().map(|spot| spot.means).collect();
            let many = spots.len() > LABELLED;
            for (spot, on_front) in spots.iter_mut().zip(on_front(&points)) {
                spot.on_front = on_front;
                if many && !on_front {
                    spot.label = None;
                }
            }
            Some(ParetoChart {
                title: format!("Mean linear error of {name} (cm)"),
                condition: condition.to_owned(),
                spots,
                joined,
                references: Vec::new(),
            })
        });
        Fronts { charts: charts.collect(), methods: methods.iter().flatten().copied().collect() }
    }
}

/// The cells of one method in one task.
struct Series<'a> {
    /// Cells sorted by value if one setting varies, otherwise in the order of the file.
    cells: Vec<usize>,
    /// Settings that vary among the cells, except the method.
    settings: Vec<&'a Column<String>>,
}

impl<'a> Series<'a> {
    fn new(mut cells: Vec<usize>, controls: &[&'a Column<String>]) -> Self {
        let varies = |setting: &&&Column<String>| {
            let mut values = cells.iter().map(|cell| &setting.values[*cell]);
            let first = values.next();
            setting.name != "controller.method" && values.any(|value| Some(value) != first)
        };
        let settings: Vec<&Column<String>> = controls.iter().filter(varies).copied().collect();
        if let [setting] = settings.as_slice() {
            let values: Vec<String> =
                cells.iter().map(|cell| setting.values[*cell].clone()).collect();
            let order = distinct(&values);
            let place = |cell: usize| order.iter().position(|value| *value == setting.values[cell]);
            cells.sort_by_key(|cell| place(*cell));
        }
        Self { cells, settings }
    }

    /// Returns whether exactly one numeric setting varies: neighbouring cells are then joined.
    fn is_line(&self) -> bool {
        let [setting] = self.settings.as_slice() else { return false };
        self.cells.iter().all(|cell| setting.values[*cell].parse::<f64>().is_ok())
    }

    fn spot(&self, cell: usize, method: Option<MethodName>, means: [f64; 2]) -> Spot {
        let name = method.map_or("", MethodName::label);
        // The last part of a key is sufficient; along a line it is written only once.
        let short = |key: &str| key.rsplit('.').next().unwrap_or(key).to_owned();
        let along = self.is_line() && self.cells.first() != Some(&cell);
        let values: Vec<String> = self
            .settings
            .iter()
            .map(|setting| match &setting.values[cell] {
                value if along => value.clone(),
                value => format!("{} {value}", short(&setting.name)),
            })
            .collect();
        let values = values.join(", ");
        let label = if values.is_empty() { name.to_owned() } else { values.clone() };
        let name =
            [name, &values].iter().filter(|part| !part.is_empty()).copied().collect::<Vec<_>>();
        Spot { method, name: name.join(" "), label: Some(label), means, on_front: false }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(text: &str) -> Sweep {
        Sweep::from_reader(csv::Reader::from_reader(text.as_bytes()), "sweep.csv").unwrap()
    }

    const HEAD: &str = "controller.method,controller.beta,dimensions.scale,all_angular_mean_deg,all_linear_mean_cm\n";

    #[test]
    fn each_task_has_a_front_of_its_methods_and_weights() {
        let mut text = HEAD.to_owned();
        for scale in ["1.0", "1.1"] {
            let cells = "world,1.0,SCALE,1.0,4.0\nlinear_compensation,1.0,SCALE,4.0,3.0\n\
                linear_compensation,0.25,SCALE,2.0,3.5\nlinear_compensation,0.5,SCALE,3.0,3.75\n";
            text += &cells.replace("SCALE", scale);
        }
        // A cell that is alone in its task, and a lost figure.
        text += "world,1.0,1.2,1.0,5.0\nlocal,1.0,1.2,,\n";
        let fronts = sweep(&text).fronts();
        let conditions: Vec<&str> =
            fronts.iter().map(|front| front.charts[0].condition.as_str()).collect();
        assert_eq!(conditions, ["dimensions.scale 1.0", "dimensions.scale 1.1"]);
        assert_eq!(fronts[0].methods, [MethodName::World, MethodName::LinearCompensation]);
        let [chart] = &fronts[0].charts[..] else { panic!("there is no column of the leaves") };
        let spots: Vec<(&str, bool)> = chart
            .spots
            .iter()
            .map(|spot| (spot.label.as_deref().unwrap(), spot.on_front))
            .collect();
        assert_eq!(spots, [("World", true), ("beta 0.25", true), ("0.5", false), ("1.0", true)]);
        let [line] = &chart.joined[..] else { panic!("one weight varies") };
        assert_eq!(line.means, [[2.0, 3.5], [3.0, 3.75], [4.0, 3.0]]);
    }

    #[test]
    fn without_methods_and_weights_there_is_no_front() {
        let text = "dimensions.scale,root,all_angular_mean_deg,all_linear_mean_cm\n\
            1.0,driven,1,1\n1.1,driven,1,2\n1.0,fixed,1,1\n1.1,fixed,1,2\n";
        assert_eq!(sweep(text).fronts(), []);
    }
}
