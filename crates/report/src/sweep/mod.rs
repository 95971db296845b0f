//! Reads a sweep's CSV, and prepares maps of one metric over two parameters, and fronts of methods and weights.

mod pareto;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use sinew_evaluation::MethodName;
use thiserror::Error;

/// The cells of a sweep, from its CSV.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// Parameters that vary, with the value of every cell.
    parameters: Vec<Column<String>>,
    /// Metrics, with the value of every cell that has one.
    metrics: Vec<Column<Option<f64>>>,
    /// Method of every cell, if the file contains it.
    methods: Vec<Option<MethodName>>,
    cells: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct Column<T> {
    name: String,
    values: Vec<T>,
}

/// A map of a metric over two parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Grid {
    /// Title of the map.
    pub title: String,
    /// Values of the other parameters by which this map differs from others.
    pub condition: String,
    /// Name of the parameter in the rows.
    pub row_name: String,
    /// Name of the parameter in the columns.
    pub column_name: String,
    /// Labels of the rows.
    pub rows: Vec<String>,
    /// Labels of the columns.
    pub columns: Vec<String>,
    /// Values row by row; `None` if there is no cell, or the cell has no value.
    pub cells: Vec<Option<f64>>,
    /// Smallest and largest value.
    pub range: (f64, f64),
}

/// The error of a sweep's file that cannot be shown.
#[derive(Debug, Error)]
pub enum SweepError {
    /// A file that is not a CSV table.
    #[error("{file}: {source}")]
    Csv {
        /// Path of the file.
        file: String,
        /// Error of the CSV reader.
        source: csv::Error,
    },
    /// A metric that is not a number.
    #[error(
        "{file}, line {line}, column {column}: expected a finite number or nothing, found `{value}`"
    )]
    Value {
        /// Path of the file.
        file: String,
        /// Number of the line.
        line: usize,
        /// Name of the column.
        column: String,
        /// The value that was found.
        value: String,
    },
    /// A file without a metric to show.
    #[error("{file}: no column of a metric, such as all_linear_mean_cm")]
    NoMetric {
        /// Path of the file.
        file: String,
    },
}

/// Endings of the names of metric columns.
const METRICS: [&str; 6] = [
    "angular_mean_deg",
    "linear_mean_cm",
    "angular_max_deg",
    "linear_max_cm",
    "weighted_mean_cm",
    "weighted_max_cm",
];

/// Names of columns that are neither metrics nor parameters.
const OTHERS: [&str; 8] =
    ["cell", "status", "reason", "n_all", "n_leaf", "widest_gap_mm", "limited", "on_front"];

impl Sweep {
    /// Reads a sweep's CSV: a row per cell, with columns for parameters, metrics and a status.
    ///
    /// # Errors
    /// [`SweepError`].
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let file = path.display().to_string();
        let reader = csv::Reader::from_path(path);
        Self::from_reader(
            reader.map_err(|source| SweepError::Csv { file: file.clone(), source })?,
            &file,
        )
    }

    fn from_reader<R: std::io::Read>(
        mut reader: csv::Reader<R>,
        file: &str,
    ) -> Result<Self, SweepError> {
        let wrong = |source| SweepError::Csv { file: file.to_owned(), source };
        let header = reader.headers().map_err(wrong)?.clone();
        let rows = reader.records().collect::<Result<Vec<_>, _>>().map_err(wrong)?;
        let (mut parameters, mut metrics) = (Vec::new(), Vec::new());
        let mut methods = vec![None; rows.len()];
        for (index, name) in header.iter().enumerate() {
            let name = name.to_owned();
            if METRICS.iter().any(|metric| name.ends_with(metric)) {
                let values = rows
                    .iter()
                    .enumerate()
                    .map(|(row, record)| {
                        metric(&record[index]).map_err(|value| SweepError::Value {
                            file: file.to_owned(),
                            line: row + 2,
                            column: name.clone(),
                            value,
                        })
                    })
                    .collect::<Result<Vec<_>, _>>()?;
                metrics.push(Column { name, values });
            } else if !OTHERS.contains(&name.as_str()) {
                let values: Vec<String> =
                    rows.iter().map(|record| record[index].to_owned()).collect();
                if name == "controller.method" {
                    methods = values.iter().map(|name| MethodName::from_name(name)).collect();
                }
                if values.iter().any(|value| *value != values[0]) {
                    parameters.push(Column { name, values });
                }
            }
        }
        if metrics.is_empty() {
            return Err(SweepError::NoMetric { file: file.to_owned() });
        }
        Ok(Self { parameters, metrics, methods, cells: rows.len() })
    }

    /// Returns the number of cells.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// Returns the names of the parameters that vary.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|parameter| parameter.name.as_str())
    }

    /// Returns heat maps: one for each mean metric and each complete grid of two parameters, the largest grids first.
    /// If there is no complete grid, returns rows over one parameter.
    pub(super) fn grids(&self) -> Vec<Grid> {
        let mut fields = self.fields();
        fields.sort_by_key(|field| std::cmp::Reverse(field.cells.len()));
        let means = self.metrics.iter().filter(|metric| metric.name.contains("_mean_"));
        let of_field = |field: &Field| -> Vec<Grid> {
            means.clone().map(|metric| self.grid(field, metric)).collect()
        };
        fields.iter().flat_map(of_field).collect()
    }

    /// Returns the grids of cells in which two parameters vary, with all combinations of their values. If there is
    /// none, returns the lines in which one parameter varies.
    fn fields(&self) -> Vec<Field> {
        let count = self.parameters.len();
        let mut fields = Vec::new();
        for a in 0..count {
            for b in a + 1..count {
                fields.extend(self.fields_over(a, Some(b)));
            }
        }
        if fields.is_empty() {
            fields.extend((0..count).flat_map(|a| self.fields_over(a, None)));
        }
        fields
    }

    fn fields_over(&self, a: usize, b: Option<usize>) -> Vec<Field> {
        let rest: Vec<usize> =
            (0..self.parameters.len()).filter(|p| *p != a && Some(*p) != b).collect();
        let mut planes: BTreeMap<Vec<&str>, Vec<usize>> = BTreeMap::new();
        for cell in 0..self.cells {
            let at = rest.iter().map(|p| self.parameters[*p].values[cell].as_str()).collect();
            planes.entry(at).or_default().push(cell);
        }
        let values = |parameter: usize, cells: &[usize]| {
            let values: Vec<String> =
                cells.iter().map(|cell| self.parameters[parameter].values[*cell].clone()).collect();
            distinct(&values)
        };
        planes.retain(|_, cells| {
            let others = b.map_or(1, |b| values(b, cells).len());
            let own = values(a, cells).len();
            own > 1 && (b.is_none() || others > 1) && cells.len() == own * others
        });
        // The condition contains only the parameters that distinguish these grids.
        let told: Vec<usize> = (0..rest.len())
            .filter(|p| planes.keys().map(|at| at[*p]).collect::<BTreeSet<_>>().len() > 1)
            .collect();
        let mut fields: Vec<Field> = planes
            .iter()
            .map(|(at, cells)| {
                let names: Vec<String> = told
                    .iter()
                    .map(|p| format!("{} {}", self.parameters[rest[*p]].name, at[*p]))
                    .collect();
                let (mut columns, mut rows) = (Some(a), b);
                if b.is_some_and(|b| values(b, cells).len() > values(a, cells).len()) {
                    (columns, rows) = (b, Some(a));
                }
                let axis = |parameter: Option<usize>| {
                    (parameter, parameter.map_or(vec![String::new()], |p| values(p, cells)))
                };
                Field {
                    columns: axis(columns),
                    rows: axis(rows),
                    condition: names.join(", "),
                    cells: cells.clone(),
                }
            })
            .collect();
        fields.sort_by_key(|field| field.cells[0]);
        fields
    }

    fn grid(&self, field: &Field, metric: &Column<Option<f64>>) -> Grid {
        let name = |axis: &Axis| axis.0.map_or(String::new(), |p| self.parameters[p].name.clone());
        let place = |axis: &Axis, cell: usize| {
            axis.0.map_or(Some(0), |p| {
                axis.1.iter().position(|value| *value == self.parameters[p].values[cell])
            })
        };
        let mut cells = vec![None; field.rows.1.len() * field.columns.1.len()];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for cell in &field.cells {
            let value = metric.values[*cell];
            if let (Some(row), Some(column)) =
                (place(&field.rows, *cell), place(&field.columns, *cell))
            {
                cells[row * field.columns.1.len() + column] = value;
            }
            if let Some(value) = value {
                (low, high) = (low.min(value), high.max(value));
            }
        }
        Grid {
            title: title(&metric.name),
            condition: field.condition.clone(),
            row_name: name(&field.rows),
            column_name: name(&field.columns),
            rows: field.rows.1.clone(),
            columns: field.columns.1.clone(),
            cells,
            range: (low, high),
        }
    }
}

/// A parameter, and its values in a grid.
type Axis = (Option<usize>, Vec<String>);

/// Cells in which only two parameters vary.
struct Field {
    columns: Axis,
    rows: Axis,
    /// Difference from the other grids of the same parameters.
    condition: String,
    cells: Vec<usize>,
}

/// Formats a metric's name for readers.
fn title(metric: &str) -> String {
    match metric {
        "all_angular_mean_deg" => "Mean angular error of all bodies (°)".into(),
        "all_linear_mean_cm" => "Mean linear error of all bodies (cm)".into(),
        "leaf_angular_mean_deg" => "Mean angular error of the leaves (°)".into(),
        "leaf_linear_mean_cm" => "Mean linear error of the leaves (cm)".into(),
        "all_weighted_mean_cm" => "Mean error weighted by importance (cm)".into(),
        other => other.replace('_', " "),
    }
}

/// Parses a metric. An empty text and NaN are no value: the cell has failed, and its status contains the reason.
fn metric(text: &str) -> Result<Option<f64>, String> {
    match text.trim() {
        "" | "NaN" => Ok(None),
        text => match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(text.to_owned()),
        },
    }
}

/// Returns the distinct values: numbers in increasing order, other texts in the order of the file.
fn distinct(values: &[String]) -> Vec<String> {
    let mut distinct: Vec<String> = Vec::new();
    for value in values {
        if !distinct.contains(value) {
            distinct.push(value.clone());
        }
    }
    let numbers: Option<Vec<f64>> = distinct.iter().map(|value| value.parse().ok()).collect();
    if let Some(numbers) = numbers {
        let mut both: Vec<(f64, String)> = numbers.into_iter().zip(distinct).collect();
        both.sort_by(|a, b| a.0.total_cmp(&b.0));
        return both.into_iter().map(|(_, value)| value).collect();
    }
    distinct
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(text: &str) -> Result<Sweep, SweepError> {
        Sweep::from_reader(csv::Reader::from_reader(text.as_bytes()), "sweep.csv")
    }

    #[test]
    fn two_parameters_make_a_field() {
        let text = "scale,kp,beta,all_linear_mean_cm,status\n\
            1.1,200,10,4.5,ok\n1.1,200,2,3.5,ok\n0.9,200,10,,diverged\n0.9,200,2,2.5,ok\n";
        let sweep = sweep(text).unwrap();
        assert_eq!(sweep.parameters().collect::<Vec<_>>(), ["scale", "beta"]);
        let [grid] = &sweep.grids()[..] else { panic!("one metric, one field") };
        assert_eq!(
            (grid.columns.as_slice(), grid.rows.as_slice()),
            (&["0.9".to_owned(), "1.1".to_owned()][..], &["2".to_owned(), "10".to_owned()][..],)
        );
        assert_eq!(grid.cells, [Some(2.5), Some(3.5), None, Some(4.5)]);
    }

    #[test]
    fn further_parameters_make_further_fields() {
        let mut text = "a,b,c,all_linear_mean_cm,leaf_linear_mean_cm\n".to_owned();
        for c in ["x", "y"] {
            for (a, b) in [(1, 1), (1, 2), (2, 1), (2, 2), (3, 1), (3, 2)] {
                text +=
                    &[a.to_string(), b.to_string(), c.into(), format!("{a}.5"), format!("{b}.5\n")]
                        .join(",");
            }
        }
        // A cell that belongs to no grid.
        text += "9,9,z,1.0,1.0\n";
        let grids = sweep(&text).unwrap().grids();
        // In order of size: a with b for each c; a with c for each b; b with c for each a.
        let sizes: Vec<usize> = grids.iter().step_by(2).map(|grid| grid.cells.len()).collect();
        assert_eq!(sizes, [6, 6, 6, 6, 4, 4, 4]);
        let first: Vec<(&str, &str)> =
            grids.iter().take(4).map(|g| (g.title.as_str(), g.condition.as_str())).collect();
        assert_eq!(
            first,
            [
                ("Mean linear error of all bodies (cm)", "c x"),
                ("Mean linear error of the leaves (cm)", "c x"),
                ("Mean linear error of all bodies (cm)", "c y"),
                ("Mean linear error of the leaves (cm)", "c y"),
            ]
        );
        assert_eq!((grids[0].column_name.as_str(), grids[0].row_name.as_str()), ("a", "b"));
    }

    #[test]
    fn one_parameter_makes_a_line() {
        let sweep = sweep("kp,all_linear_mean_cm\n300,2\n100,1\n").unwrap();
        let [grid] = &sweep.grids()[..] else { panic!("one metric, one line") };
        assert_eq!((grid.columns.len(), grid.rows.len()), (2, 1));
        assert_eq!(grid.cells, [Some(1.0), Some(2.0)]);
    }

    #[test]
    fn bad_tables_are_refused() {
        let error = sweep("kp,all_linear_mean_cm\n1,2\n2,inf\n").unwrap_err().to_string();
        assert!(
            error.contains("line 3, column all_linear_mean_cm") && error.contains("`inf`"),
            "{error}"
        );
        assert!(sweep("kp,beta\n1,2\n").unwrap_err().to_string().contains("no column of a metric"));
        assert!(sweep("kp,all_linear_mean_cm\n1\n").is_err());
    }
}
