//! Sweep files (TOML): what all setups have in common, and grids of what they have not.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::error::{SweepError, io};
use crate::evaluate::Setup;

/// A sweep file, read and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepFile {
    /// The text, as it was read.
    pub text: String,
    /// The cells of all grids in their order, each setup once.
    pub cells: Vec<Cell>,
    /// Cells that were left out because an earlier one has the same setup.
    pub repeated: usize,
}

/// One setup of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// The setup.
    pub setup: Setup,
    /// The same in TOML, with every key: equal for equal setups.
    pub key: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// Keys of a setup that all cells have.
    #[serde(default)]
    setup: toml::Table,
    /// Keys of a setup with lists of values: every combination is a cell.
    grid: Vec<toml::Table>,
}

impl SweepFile {
    /// Reads a sweep file.
    ///
    /// The cells of a grid go through its lists, the last key in alphabetical order fastest.
    ///
    /// # Errors
    /// [`SweepError`] with the file's name and what is wrong where; nothing has been run then.
    pub fn read(path: &Path) -> Result<Self, SweepError> {
        let text = std::fs::read_to_string(path).map_err(io(path))?;
        Self::parse(text, path)
    }

    /// Reads the text of the sweep file at `path`.
    ///
    /// # Errors
    /// As [`Self::read`].
    pub fn parse(text: String, path: &Path) -> Result<Self, SweepError> {
        let file = || PathBuf::from(path);
        let content: File = toml::from_str(&text)
            .map_err(|source| SweepError::Toml { file: file(), source: Box::new(source) })?;
        let setup_error = |grid, values: String| {
            move |source| SweepError::Setup { file: path.to_path_buf(), grid, values, source }
        };
        Setup::from_table(content.setup.clone()).map_err(setup_error(0, "[setup]".to_owned()))?;

        let mut cells: Vec<Cell> = Vec::new();
        let mut repeated = 0;
        for (number, grid) in (1..).zip(&content.grid) {
            let grid_error = |what| SweepError::Grid { file: file(), grid: number, what };
            let axes = axes(grid).map_err(grid_error)?;
            for values in combinations(&axes) {
                let mut table = content.setup.clone();
                for ((key, _), value) in axes.iter().zip(&values) {
                    insert(&mut table, key, (*value).clone()).map_err(grid_error)?;
                }
                let setup =
                    Setup::from_table(table).map_err(setup_error(number, names(&axes, &values)))?;
                let key = toml::to_string(&setup).expect("every setup can be written in TOML");
                if cells.iter().any(|cell| cell.key == key) {
                    repeated += 1;
                } else {
                    cells.push(Cell { setup, key });
                }
            }
        }
        if cells.is_empty() {
            let what = "expected at least one [[grid]] with lists of values".to_owned();
            return Err(SweepError::Grid { file: file(), grid: 1, what });
        }
        Ok(Self { text, cells, repeated })
    }
}

/// A key of a setup, dotted into its parts, and its values.
type Axis = (Vec<String>, Vec<toml::Value>);

/// The axes of a grid in alphabetical order; a single value is a list of one.
fn axes(grid: &toml::Table) -> Result<Vec<Axis>, String> {
    let mut axes = Vec::new();
    collect(&[], grid, &mut axes)?;
    Ok(axes)
}

fn collect(path: &[String], table: &toml::Table, axes: &mut Vec<Axis>) -> Result<(), String> {
    for (key, value) in table {
        let path = [path, std::slice::from_ref(key)].concat();
        match value {
            toml::Value::Table(inner) => collect(&path, inner, axes)?,
            toml::Value::Array(values) if values.is_empty() => {
                return Err(format!("{}: expected a list of values, found none", path.join(".")));
            }
            toml::Value::Array(values) => axes.push((path, values.clone())),
            single => axes.push((path, vec![single.clone()])),
        }
    }
    Ok(())
}

/// Every combination of one value of each axis, the last axis fastest.
fn combinations(axes: &[Axis]) -> Vec<Vec<&toml::Value>> {
    let mut all = vec![Vec::new()];
    for (_, values) in axes {
        all = all
            .into_iter()
            .flat_map(|combination: Vec<&toml::Value>| {
                values.iter().map(move |value| {
                    let mut longer = combination.clone();
                    longer.push(value);
                    longer
                })
            })
            .collect();
    }
    all
}

fn names(axes: &[Axis], values: &[&toml::Value]) -> String {
    let pairs =
        axes.iter().zip(values).map(|((key, _), value)| format!("{} = {value}", key.join(".")));
    pairs.collect::<Vec<_>>().join(", ")
}

fn insert(table: &mut toml::Table, key: &[String], value: toml::Value) -> Result<(), String> {
    match key {
        [] => Ok(()),
        [last] => {
            table.insert(last.clone(), value);
            Ok(())
        }
        [first, rest @ ..] => {
            let inner = table.entry(first).or_insert_with(|| toml::Table::new().into());
            match inner.as_table_mut() {
                Some(inner) => insert(inner, rest, value),
                None => Err(format!("`{first}` has no keys of its own")),
            }
        }
    }
}
