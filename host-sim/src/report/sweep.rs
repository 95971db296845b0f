//! A sweep's CSV as fields of cells: one metric over two parameters.

use std::collections::BTreeMap;
use std::path::Path;

use thiserror::Error;

/// The cells of a sweep, as its CSV has them.
#[derive(Debug, Clone, PartialEq)]
pub struct Sweep {
    /// The parameters that vary, with the value of every cell.
    parameters: Vec<Column<String>>,
    /// The metrics, with the value of every cell that has one.
    metrics: Vec<Column<Option<f64>>>,
    cells: usize,
}

#[derive(Debug, Clone, PartialEq)]
struct Column<T> {
    name: String,
    values: Vec<T>,
}

/// One field: a metric over two parameters.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    pub(super) title: String,
    pub(super) row_name: String,
    pub(super) column_name: String,
    pub(super) rows: Vec<String>,
    pub(super) columns: Vec<String>,
    /// By row; `None` where there is no cell, or no value in it.
    pub(super) cells: Vec<Option<f64>>,
    /// Smallest and largest value of the metric in the whole sweep, so that fields can be compared.
    pub(super) range: (f64, f64),
}

/// Why a sweep's file cannot be shown.
#[derive(Debug, Error)]
pub enum SweepError {
    /// Not a table.
    #[error("{file}: {source}")]
    Csv {
        /// The file.
        file: String,
        /// Why.
        source: csv::Error,
    },
    /// A metric that is no number.
    #[error(
        "{file}, line {line}, column {column}: expected a finite number or nothing, found `{value}`"
    )]
    Value {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// The column's name.
        column: String,
        /// What it is.
        value: String,
    },
    /// Nothing to show.
    #[error("{file}: no column of a metric, such as all_linear_mean_cm")]
    NoMetric {
        /// The file.
        file: String,
    },
}

/// Endings of the columns that are metrics.
const METRICS: [&str; 4] =
    ["angular_mean_deg", "linear_mean_cm", "angular_max_deg", "linear_max_cm"];

/// Columns that are neither metrics nor parameters.
const OTHERS: [&str; 7] =
    ["cell", "status", "reason", "n_all", "n_leaf", "widest_gap_mm", "limited"];

impl Sweep {
    /// Reads a sweep's CSV: a row per cell; columns of parameters, metrics and a status.
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
                if values.iter().any(|value| *value != values[0]) {
                    parameters.push(Column { name, values });
                }
            }
        }
        if metrics.is_empty() {
            return Err(SweepError::NoMetric { file: file.to_owned() });
        }
        Ok(Self { parameters, metrics, cells: rows.len() })
    }

    /// Number of cells.
    pub(super) fn cells(&self) -> usize {
        self.cells
    }

    /// The names of the parameters that vary.
    pub(super) fn parameters(&self) -> impl Iterator<Item = &str> {
        self.parameters.iter().map(|parameter| parameter.name.as_str())
    }

    /// Every mean over the two parameters with the most values, once for each choice of the others.
    pub(super) fn grids(&self) -> Vec<Grid> {
        let mut order: Vec<(usize, Vec<String>)> =
            self.parameters.iter().map(|column| distinct(&column.values)).enumerate().collect();
        order.sort_by_key(|(index, values)| (std::cmp::Reverse(values.len()), *index));
        let axis = |place: usize| {
            order.get(place).map_or((None, vec![String::new()]), |(index, values)| {
                (Some(&self.parameters[*index]), values.clone())
            })
        };
        let ((column, columns), (row, rows)) = (axis(0), axis(1));
        let others: Vec<&Column<String>> =
            order.iter().skip(2).map(|(index, _)| &self.parameters[*index]).collect();
        let name =
            |column: Option<&Column<String>>| column.map_or(String::new(), |c| c.name.clone());
        let place = |column: Option<&Column<String>>, values: &[String], cell: usize| {
            column.map_or(Some(0), |column| {
                values.iter().position(|value| *value == column.values[cell])
            })
        };

        let mut grids = Vec::new();
        for metric in self.metrics.iter().filter(|metric| metric.name.contains("_mean_")) {
            let range = metric
                .values
                .iter()
                .flatten()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
                    (low.min(*value), high.max(*value))
                });
            // In the order of the file.
            let mut titles: Vec<String> = Vec::new();
            let mut found: BTreeMap<usize, Grid> = BTreeMap::new();
            for cell in 0..self.cells {
                let rest: Vec<String> =
                    others.iter().map(|o| format!("{} {}", o.name, o.values[cell])).collect();
                let title_of_cell = [vec![title(&metric.name)], rest].concat().join(", ");
                let index =
                    titles.iter().position(|known| *known == title_of_cell).unwrap_or_else(|| {
                        titles.push(title_of_cell.clone());
                        titles.len() - 1
                    });
                let grid = found.entry(index).or_insert_with(|| Grid {
                    title: title_of_cell,
                    row_name: name(row),
                    column_name: name(column),
                    rows: rows.clone(),
                    columns: columns.clone(),
                    cells: vec![None; rows.len() * columns.len()],
                    range,
                });
                if let (Some(r), Some(c)) = (place(row, &rows, cell), place(column, &columns, cell))
                {
                    grid.cells[r * columns.len() + c] = metric.values[cell];
                }
            }
            grids.extend(found.into_values());
        }
        grids
    }
}

/// A metric's name as one reads it.
fn title(metric: &str) -> String {
    match metric {
        "all_angular_mean_deg" => "Mean angular error of all bodies (°)".into(),
        "all_linear_mean_cm" => "Mean linear error of all bodies (cm)".into(),
        "leaf_angular_mean_deg" => "Mean angular error of the leaves (°)".into(),
        "leaf_linear_mean_cm" => "Mean linear error of the leaves (cm)".into(),
        other => other.replace('_', " "),
    }
}

/// Nothing and NaN are no value: the cell has failed, and its status says why.
fn metric(text: &str) -> Result<Option<f64>, String> {
    match text.trim() {
        "" | "NaN" => Ok(None),
        text => match text.parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Some(value)),
            _ => Err(text.to_owned()),
        },
    }
}

/// The values there are: numbers by size, other words in the order of the file.
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
        for (a, b, c) in [(1, 1, "x"), (1, 2, "x"), (2, 1, "x"), (3, 2, "y")] {
            text += &[a.to_string(), b.to_string(), c.into(), format!("{a}.5"), format!("{b}.5")]
                .join(",");
            text.push('\n');
        }
        let titles: Vec<String> =
            sweep(&text).unwrap().grids().into_iter().map(|g| g.title).collect();
        assert_eq!(
            titles,
            [
                "Mean linear error of all bodies (cm), c x",
                "Mean linear error of all bodies (cm), c y",
                "Mean linear error of the leaves (cm), c x",
                "Mean linear error of the leaves (cm), c y",
            ]
        );
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
