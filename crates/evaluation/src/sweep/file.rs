//! Sweep files (TOML): common keys of all setups, and grids of the keys that vary.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use sinew_mocap::{Kind, read};
use sinew_rig::Mechanism;

use super::error::{SweepError, io};
use crate::Setup;

/// Maximum number of cells. A larger number is a mistake in a list, and would not fit in memory.
const MOST_CELLS: usize = 100_000;

/// A sweep file, read and checked.
#[derive(Debug, Clone, PartialEq)]
pub struct SweepFile {
    /// Text of the file.
    pub text: String,
    /// Cells of all grids in their order, without repetitions of a setup.
    pub cells: Vec<Cell>,
    /// Number of cells that were omitted because an earlier cell has the same setup.
    pub repeated: usize,
}

/// One setup of a sweep.
#[derive(Debug, Clone, PartialEq)]
pub struct Cell {
    /// Setup of the cell.
    pub setup: Setup,
    /// Setup as TOML with every key: equal setups have equal texts.
    pub key: String,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    /// Keys of a setup that apply to all cells.
    #[serde(default)]
    setup: toml::Table,
    /// Keys of a setup with lists of values. Every combination is a cell.
    grid: Vec<toml::Table>,
}

impl SweepFile {
    /// Reads a sweep file, for a user's rig or for the figure. For a rig, the plant is the exact plant if the file
    /// names none.
    ///
    /// The cells of a grid iterate over its lists, with the last key in alphabetical order fastest. Keys may be
    /// dotted, also in quotes, or be in tables.
    ///
    /// # Errors
    /// [`SweepError`] with the file's name and the place of the fault. Nothing has been run in that case.
    pub fn read(path: &Path, rig: Option<&Mechanism>) -> Result<Self, SweepError> {
        let kinds = [Kind::Sweep, Kind::Toml];
        let text = read::text_of(path, "a sweep in TOML", &kinds).map_err(io(path))?;
        Self::parse(text, path, rig)
    }

    /// Parses the text of the sweep file at `path`.
    ///
    /// # Errors
    /// Those of [`Self::read`].
    pub fn parse(text: String, path: &Path, rig: Option<&Mechanism>) -> Result<Self, SweepError> {
        let file = || PathBuf::from(path);
        let mut content: File = toml::from_str(&text)
            .map_err(|source| SweepError::Toml { file: file(), source: Box::new(source) })?;
        if rig.is_some() {
            Setup::prefer_exact_plant(&mut content.setup);
        }

        let mut cells: Vec<Cell> = Vec::new();
        let mut keys = BTreeSet::new();
        let mut repeated = 0;
        let mut left = MOST_CELLS;
        for (number, grid) in (1..).zip(&content.grid) {
            let grid_error = |what| SweepError::Grid { file: file(), grid: number, what };
            let axes = axes(grid).map_err(grid_error)?;
            left = remaining(left, &axes).map_err(grid_error)?;
            for values in combinations(&axes) {
                let mut table = content.setup.clone();
                for ((key, _), value) in axes.iter().zip(&values) {
                    insert(&mut table, key, (*value).clone()).map_err(grid_error)?;
                }
                let read = |table| {
                    let setup = Setup::from_table(table)?;
                    setup.check_for(rig).map(|()| setup)
                };
                let setup = read(table).map_err(|source| {
                    // A fault that exists without the grid's values is not the grid's fault.
                    let common = read(content.setup.clone());
                    let place = if common.as_ref() == Err(&source) {
                        "[setup]".to_owned()
                    } else {
                        format!("grid {number}, {}", names(&axes, &values))
                    };
                    SweepError::Setup { file: file(), place, source }
                })?;
                let key = setup.to_toml();
                if keys.insert(key.clone()) {
                    cells.push(Cell { setup, key });
                } else {
                    repeated += 1;
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

/// A key of a setup as a list of its parts, and the values of the key.
type Axis = (Vec<String>, Vec<toml::Value>);

/// Returns the axes of a grid in alphabetical order. A single value counts as a list of one.
fn axes(grid: &toml::Table) -> Result<Vec<Axis>, String> {
    let mut axes = Vec::new();
    collect(&[], grid, &mut axes)?;
    // `beta` in `controller` and "controller.beta" are one key, but TOML treats them as two.
    let mut keys = BTreeSet::new();
    match axes.iter().find(|(key, _)| !keys.insert(key)) {
        Some((key, _)) => Err(format!("{}: expected once, found twice", key.join("."))),
        None => Ok(axes),
    }
}

fn collect(path: &[String], table: &toml::Table, axes: &mut Vec<Axis>) -> Result<(), String> {
    for (key, value) in table {
        let path: Vec<String> =
            path.iter().cloned().chain(key.split('.').map(str::to_owned)).collect();
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

/// Returns the number of cells that remain allowed after a grid with these axes.
fn remaining(left: usize, axes: &[Axis]) -> Result<usize, String> {
    let cells = axes.iter().try_fold(1usize, |cells, (_, values)| cells.checked_mul(values.len()));
    cells.and_then(|cells| left.checked_sub(cells)).ok_or_else(|| {
        let lengths: Vec<_> = axes.iter().map(|(_, values)| values.len().to_string()).collect();
        format!(
            "expected at most {MOST_CELLS} cells in all grids, found {} of them after {}",
            lengths.join(" x "),
            MOST_CELLS - left
        )
    })
}

/// Returns every combination of one value of each axis, the last axis fastest.
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

#[cfg(test)]
mod tests {
    use super::*;

    fn parse(text: &str) -> Result<SweepFile, String> {
        SweepFile::parse(text.to_owned(), Path::new("s.toml"), None)
            .map_err(|error| error.to_string())
    }

    #[test]
    fn cells_are_numbered_with_the_last_key_fastest_and_grids_in_turn() {
        let text = "setup.plant.substeps = 2
            [[grid]]
            dimensions.scale = [0.9, 1.1]
            'controller.beta' = [0.0, 1.0]
            [[grid]]
            controller.kp = 50
            dimensions.scale = 0.9
            [[grid]]
            dimensions.scale = [1.1, 1.2]";
        let file = parse(text).unwrap();
        let cells: Vec<_> = file
            .cells
            .iter()
            .map(|cell| {
                let Setup { controller, dimensions, plant, .. } = &cell.setup;
                assert_eq!(plant.substeps, 2);
                (controller.beta, controller.kp, dimensions.scale)
            })
            .collect();
        let expected = [
            (0.0, 200.0, 0.9),
            (0.0, 200.0, 1.1),
            (1.0, 200.0, 0.9),
            (1.0, 200.0, 1.1),
            (1.0, 50.0, 0.9),
            (1.0, 200.0, 1.2),
        ];
        assert_eq!((cells.as_slice(), file.repeated), (expected.as_slice(), 1));
    }

    #[test]
    fn what_all_have_in_common_need_not_be_a_setup_by_itself() {
        let text = "setup.controller.gains = 'articulated_inertia'
            [[grid]]
            controller.law = 'pd'";
        assert_eq!(parse(text).unwrap().cells.len(), 1);
        let error = parse(&format!("{text}\n[[grid]]")).unwrap_err();
        assert!(error.starts_with("s.toml: [setup]: controller.gains: "), "{error}");
    }

    #[test]
    fn refusals_say_where_and_what_would_be_right() {
        let many = format!("[{}]", "0,".repeat(1000));
        let seeds = format!("disturbance.seed = {many}\ndimensions.seed = {many}");
        for (text, told) in [
            ("setup.plant.substeps = 0\n[[grid]]", "s.toml: [setup]: plant.substeps: expected a"),
            (
                "[[grid]]\n[[grid]]\ncontroller.beta = [1, 3]",
                "s.toml: grid 2, controller.beta = 3: controller.beta: expected a weight from 0 to 2",
            ),
            (
                "[[grid]]\ncontroller.beta = 1\n'controller.beta' = 0",
                "s.toml: grid 1: controller.beta: expected once, found twice",
            ),
            (
                "[[grid]]\nplant = 'rapier'\n'plant.kind' = 'rapier'",
                "s.toml: grid 1: `plant` has no keys of its own",
            ),
            (
                &format!("[[grid]]\n[[grid]]\n{seeds}"),
                "grid 2: expected at most 100000 cells in all grids, found 1000 x 1000 of them after 1",
            ),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
    }
}
