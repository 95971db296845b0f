//! Inverse dynamics of a rig for rows of a table, so that scripts can compare it with other programs.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sinew_core::TreeError;
use sinew_core::coordinates::CoordinatesError;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{InverseDynamics, JointModel, Link, Ties};
use thiserror::Error;

/// Error of a table that is refused.
#[derive(Debug, Error)]
pub enum DynamicsError {
    /// The rig does not fit `sinew-core`.
    #[error(transparent)]
    Tree(#[from] TreeError),
    /// The table is not valid CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The header has a column that does not belong to the rig.
    #[error("column `{found}`: expected q.NAME, qd.NAME or qdd.NAME of {expected}")]
    UnknownColumn {
        /// Name of the column.
        found: String,
        /// Names that the rig has.
        expected: String,
    },
    /// The header has a column twice.
    #[error("column `{0}` occurs twice")]
    RepeatedColumn(String),
    /// The header lacks a column.
    #[error("the column `{0}` is missing")]
    MissingColumn(String),
    /// A field is not a number from -1e6 to 1e6.
    #[error("line {line}, column `{column}`: expected a number from -1e6 to 1e6, found `{found}`")]
    Number {
        /// Line of the table.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text of the field.
        found: String,
    },
    /// The core refuses a row.
    #[error("line {line}: {source}")]
    Row {
        /// Line of the table.
        line: u64,
        /// Reason for the refusal.
        source: CoordinatesError,
    },
}

/// Returns the rig with its base fixed, and without rotor inertias unless `rotor`.
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

/// Returns the names of the dofs, with the base fixed.
pub fn dof_names(mechanism: &Mechanism) -> Vec<String> {
    held(mechanism, false).dof_names()
}

/// Returns the names of the joint coordinates: those of the dofs, but `NAME.x` to `NAME.w` for ball joints.
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

/// Computes the efforts of every row of a CSV with columns `q.NAME`, `qd.NAME`, `qdd.NAME` in any order, in SI units,
/// the base at rest. The output has columns `tau.NAME` with nine digits. Without any column of `qd`, or of `qdd`,
/// these values are zero. A joint that follows another needs no column: it follows.
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
    let ties = mechanism.ties();
    let columns = Columns::of(&header, &coordinate_names(&mechanism), &names, &ties)?;

    let tau: Vec<String> = names.iter().map(|name| format!("tau.{name}")).collect();
    let mut out = tau.join(",");
    out.push('\n');
    let mut dynamics = InverseDynamics::of(&mechanism)?;
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let number = |column: &usize| -> Result<f64, DynamicsError> {
            let found = record.get(*column).unwrap_or_default();
            match found.parse::<f64>() {
                Ok(x) if x.abs() <= 1e6 => Ok(x),
                _ => Err(DynamicsError::Number {
                    line,
                    column: header.get(*column).cloned().unwrap_or_default(),
                    found: found.to_owned(),
                }),
            }
        };
        let row = |columns: &[Option<usize>]| -> Result<Vec<f64>, DynamicsError> {
            columns.iter().map(|column| column.as_ref().map_or(Ok(0.0), number)).collect()
        };
        let [mut q, mut qd, mut qdd] = [row(&columns.q)?, row(&columns.qd)?, row(&columns.qdd)?];
        for tie in ties.each() {
            let ([own, leader], [dof, of]) = (tie.places(), tie.dofs());
            if columns.q[own].is_none() {
                q[own] = tie.factor * q[leader] + tie.offset;
            }
            for (rates, columns) in [(&mut qd, &columns.qd), (&mut qdd, &columns.qdd)] {
                if columns[dof].is_none() {
                    rates[dof] = tie.factor * rates[of];
                }
            }
        }
        let single = |numbers: &[f64]| -> Vec<f32> {
            #[expect(clippy::cast_possible_truncation, reason = "the core computes in f32")]
            numbers.iter().map(|x| *x as f32).collect()
        };
        let efforts = dynamics
            .efforts(&single(&q), &single(&qd), &single(&qdd))
            .map_err(|source| DynamicsError::Row { line, source })?;
        for (place, effort) in efforts.iter().enumerate() {
            let comma = if place > 0 { "," } else { "" };
            write!(out, "{comma}{effort:.8e}").expect("a string takes everything");
        }
        out.push('\n');
    }
    Ok(out)
}

/// Columns of a row's numbers, by coordinate and by dof; `None` for rates of a kind that the table does not have, and
/// for joints that follow others.
struct Columns {
    q: Vec<Option<usize>>,
    qd: Vec<Option<usize>>,
    qdd: Vec<Option<usize>>,
}

impl Columns {
    fn of(
        header: &[String],
        coordinates: &[String],
        dofs: &[String],
        ties: &Ties,
    ) -> Result<Self, DynamicsError> {
        let mut places = BTreeMap::new();
        for (place, name) in header.iter().enumerate() {
            if places.insert(name.as_str(), place).is_some() {
                return Err(DynamicsError::RepeatedColumn(name.clone()));
            }
        }
        let follows = |place: usize| ties.each().any(|tie| tie.places()[0] == place);
        let follows_at = |place: usize| ties.each().any(|tie| tie.dofs()[0] == place);
        let mut take = |kind: &str,
                        names: &[String],
                        follows: &dyn Fn(usize) -> bool,
                        needed: bool| {
            let given: Vec<_> =
                names.iter().map(|name| places.remove(format!("{kind}.{name}").as_str())).collect();
            if !needed && given.iter().all(Option::is_none) {
                return Ok(given);
            }
            let is_missing =
                |(place, given): &(usize, &Option<usize>)| given.is_none() && !follows(*place);
            match given.iter().enumerate().find(is_missing) {
                None => Ok(given),
                Some((place, _)) => {
                    Err(DynamicsError::MissingColumn(format!("{kind}.{}", names[place])))
                }
            }
        };
        let columns = Self {
            q: take("q", coordinates, &follows, true)?,
            qd: take("qd", dofs, &follows_at, false)?,
            qdd: take("qdd", dofs, &follows_at, false)?,
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
