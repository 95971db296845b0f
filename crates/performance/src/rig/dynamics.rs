//! Inverse dynamics of a rig for rows of a table: what scripts compare with other programs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{InverseDynamics, JointModel, Link};
use thiserror::Error;

/// Why a table was refused.
#[derive(Debug, Error)]
pub enum DynamicsError {
    /// The rig does not fit `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The table is no CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The header has a column that the rig has no use for.
    #[error("column `{found}`: expected q.NAME, qd.NAME or qdd.NAME of {expected}")]
    UnknownColumn {
        /// The column.
        found: String,
        /// The names that there are.
        expected: String,
    },
    /// The header has a column twice.
    #[error("column `{0}` stands twice")]
    RepeatedColumn(String),
    /// The header lacks a column.
    #[error("the column `{0}` is missing")]
    MissingColumn(String),
    /// A field is no number that a machine has.
    #[error("line {line}, column `{column}`: expected a number from -1e6 to 1e6, found `{found}`")]
    Number {
        /// Line of the table.
        line: u64,
        /// Column's name.
        column: String,
        /// The field.
        found: String,
    },
    /// The core refuses a row.
    #[error("line {line}: {source}")]
    Row {
        /// Line of the table.
        line: u64,
        /// Why.
        source: CoordinatesError,
    },
}

/// The rig with its base held, and without rotors unless they count.
fn held(mechanism: &Mechanism, rotor: bool) -> Mechanism {
    let mut held = mechanism.clone();
    for link in &mut held.bodies {
        if link.joint == JointModel::Free {
            link.joint = JointModel::Fixed;
            link.home.clear();
        }
        if !rotor {
            link.rotor_inertia = 0.0;
        }
    }
    held
}

/// Names of the degrees of freedom, the base held.
pub fn dof_names(mechanism: &Mechanism) -> Vec<String> {
    held(mechanism, false).dof_names()
}

/// Names of the joint coordinates: those of the dofs, but `NAME.x` to `NAME.w` of ball joints.
fn coordinate_names(mechanism: &Mechanism) -> Vec<String> {
    let of_link = |link: &Link| {
        let name = link.joint_name.clone();
        let parts: &[&str] = match link.joint {
            JointModel::Fixed | JointModel::Free => &[],
            JointModel::Revolute(_) | JointModel::Prismatic(_) => &[""],
            JointModel::Universal(_) => &[".0", ".1"],
            JointModel::Spherical => &[".x", ".y", ".z", ".w"],
        };
        parts.iter().map(move |part| format!("{name}{part}"))
    };
    mechanism.bodies.iter().flat_map(of_link).collect()
}

/// Efforts of every row of a CSV: columns `q.NAME`, `qd.NAME`, `qdd.NAME` in any order, SI, the base at rest; to
/// columns
/// `tau.NAME` with nine digits. A table without any column of `qd`, or of `qdd`, is one of rigs at rest, or moving
/// steadily.
///
/// # Errors
/// [`DynamicsError`] names line and column.
pub fn inverse_dynamics(
    mechanism: &Mechanism,
    rotor: bool,
    table: impl std::io::Read,
) -> Result<String, DynamicsError> {
    let mechanism = held(mechanism, rotor);
    let names = mechanism.dof_names();
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(table);
    let header: Vec<String> = reader
        .headers()?
        .iter()
        .map(|name| name.trim_start_matches('\u{feff}').to_owned())
        .collect();
    let columns = Columns::of(&header, &coordinate_names(&mechanism), &names)?;

    let tau: Vec<String> = names.iter().map(|name| format!("tau.{name}")).collect();
    let mut out = tau.join(",");
    out.push('\n');
    let mut dynamics = InverseDynamics::of(&mechanism)?;
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |column: &usize| -> Result<f32, DynamicsError> {
            let found = record.get(*column).unwrap_or_default();
            match found.parse::<f64>() {
                #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
                Ok(x) if x.abs() <= 1e6 => Ok(x as f32),
                _ => Err(DynamicsError::Number {
                    line,
                    column: header.get(*column).cloned().unwrap_or_default(),
                    found: found.to_owned(),
                }),
            }
        };
        let row = |columns: &[usize], count: usize| -> Result<Vec<f32>, DynamicsError> {
            if columns.is_empty() {
                Ok(vec![0.0; count])
            } else {
                columns.iter().map(number).collect()
            }
        };
        let q = row(&columns.q, columns.q.len())?;
        let [qd, qdd] = [&columns.qd, &columns.qdd].map(|columns| row(columns, names.len()));
        let efforts = dynamics
            .efforts(&q, &qd?, &qdd?)
            .map_err(|source| DynamicsError::Row { line, source })?;
        for (place, effort) in efforts.iter().enumerate() {
            let comma = if place > 0 { "," } else { "" };
            write!(out, "{comma}{effort:.8e}").expect("a string takes everything");
        }
        out.push('\n');
    }
    Ok(out)
}

/// The columns of a row's numbers, by coordinate and by dof; empty if the table has none of the kind.
struct Columns {
    q: Vec<usize>,
    qd: Vec<usize>,
    qdd: Vec<usize>,
}

impl Columns {
    fn of(
        header: &[String],
        coordinates: &[String],
        dofs: &[String],
    ) -> Result<Self, DynamicsError> {
        let mut places = BTreeMap::new();
        for (place, name) in header.iter().enumerate() {
            if places.insert(name.as_str(), place).is_some() {
                return Err(DynamicsError::RepeatedColumn(name.clone()));
            }
        }
        let mut take = |kind: &str, names: &[String], needed: bool| {
            let given: Vec<_> =
                names.iter().map(|name| places.remove(format!("{kind}.{name}").as_str())).collect();
            if !needed && given.iter().all(Option::is_none) {
                return Ok(Vec::new());
            }
            let found = given.into_iter().zip(names).map(|(place, name)| {
                place.ok_or_else(|| DynamicsError::MissingColumn(format!("{kind}.{name}")))
            });
            found.collect()
        };
        let columns = Self {
            q: take("q", coordinates, true)?,
            qd: take("qd", dofs, false)?,
            qdd: take("qdd", dofs, false)?,
        };
        match places.keys().next() {
            None => Ok(columns),
            Some(found) => Err(DynamicsError::UnknownColumn {
                found: (*found).to_owned(),
                expected: dofs.join(", "),
            }),
        }
    }
}
