//! Writes a motion as a CSV table of joint coordinates, and reads it.

use std::fmt::Write as _;

use glam::DQuat;
use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, Link, Ties};

use crate::feasibility::{MotionError, RigMotion};

/// Returns the rotation from Sinew's world (y up) to a world with z up: 90 deg about x. x is unchanged, y becomes
/// z, z becomes -y.
fn to_z_up() -> DQuat {
    DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2)
}

/// Returns the motion as CSV: `time` in s, which is `start_s` in the first row, then a column for each coordinate
/// with the joint's name, in rad and m.
///
/// A hinge or a slide has one column; other joints have `NAME.0`, `NAME.1` (universal) or `NAME.x` to `NAME.w`
/// (ball). A driven base has `root_x root_y root_z root_qw root_qx root_qy root_qz`: the pose of its body in a
/// world with z up, which is the convention of robot programs.
pub fn csv(mechanism: &Mechanism, motion: &RigMotion, start_s: f64) -> String {
    let mut text = String::from("time");
    for link in &mechanism.bodies {
        for column in columns(link) {
            text.push(',');
            text.push_str(&quoted(&column));
        }
    }
    text.push('\n');
    let ranges = mechanism.coordinate_ranges();
    for (row, q) in motion.rows.iter().enumerate() {
        number(&mut text, start_s + row as f64 * motion.dt_s);
        let poses = mechanism.poses(q);
        for ((link, range), pose) in mechanism.bodies.iter().zip(&ranges).zip(&poses) {
            if link.joint == JointModel::Free {
                let rotation = to_z_up() * pose.rotation;
                let position = to_z_up() * pose.position_m;
                let [x, y, z, w] = rotation.to_array();
                for value in position.to_array().into_iter().chain([w, x, y, z]) {
                    text.push(',');
                    number(&mut text, value);
                }
                continue;
            }
            for value in q.get(range.clone()).unwrap_or_default() {
                text.push(',');
                number(&mut text, *value);
            }
        }
        text.push('\n');
    }
    text
}

/// Returns the names of a joint's columns.
fn columns(link: &Link) -> Vec<String> {
    let name = &link.joint_name;
    match link.joint {
        JointModel::Fixed => vec![],
        JointModel::Revolute(_) | JointModel::Prismatic(_) => vec![name.clone()],
        JointModel::Universal(_) => ["0", "1"].map(|axis| format!("{name}.{axis}")).to_vec(),
        JointModel::Spherical => ["x", "y", "z", "w"].map(|part| format!("{name}.{part}")).to_vec(),
        JointModel::Free => {
            ["x", "y", "z", "qw", "qx", "qy", "qz"].map(|part| format!("root_{part}")).to_vec()
        }
    }
}

/// The reason why a table is not a valid motion of a rig.
#[derive(Debug, thiserror::Error)]
pub enum TableError {
    /// The text is not CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The first column is not the time.
    #[error("the first column is `{0}`: expected `time`, in s")]
    NoTime(String),
    /// A column does not belong to the rig.
    #[error("column `{found}`: expected one of {expected}")]
    Column {
        /// Name of the column.
        found: String,
        /// Names of the valid columns.
        expected: String,
    },
    /// A column occurs twice.
    #[error("column `{0}` occurs twice")]
    Twice(String),
    /// A field is not a number.
    #[error("line {line}, column `{column}`: expected a number from -1e6 to 1e6, found `{found}`")]
    Number {
        /// Line of the file.
        line: u64,
        /// Name of the column.
        column: String,
        /// Text that was found.
        found: String,
    },
    /// Rows are not evenly spaced.
    #[error(
        "line {line}: expected the time {expected:.6} s, as the rows before are {step:.6} s apart, found {found}"
    )]
    Uneven {
        /// Line of the file.
        line: u64,
        /// Expected time, s.
        expected: f64,
        /// Time from row to row, s.
        step: f64,
        /// Time that was found, s.
        found: f64,
    },
    /// The rig's base travels; the table of [`csv()`] has its pose in another world.
    #[error("the rig's base travels (`root_x` ..): hold it with `--base stand`")]
    Travels,
    /// The numbers are not a valid motion.
    #[error(transparent)]
    Motion(#[from] MotionError),
}

/// Reads a table in the format of [`csv()`]. Returns the motion, and the time of its first row, s. `time` is the
/// first column; the others may have any order. A joint without a column stays at home; one that follows another joint
/// follows it, and one that others follow is where a follower with a column puts it.
///
/// # Errors
/// [`TableError`] names line and column.
pub fn read(mechanism: &Mechanism, text: &str) -> Result<(RigMotion, f64), TableError> {
    let names: Vec<String> = mechanism.bodies.iter().flat_map(columns).collect();
    if mechanism.bodies.iter().any(|link| link.joint == JointModel::Free) {
        return Err(TableError::Travels);
    }
    let text = text.trim_start_matches('\u{feff}');
    let mut reader = csv::ReaderBuilder::new().trim(csv::Trim::All).from_reader(text.as_bytes());
    let header: Vec<String> = reader.headers()?.iter().map(str::to_owned).collect();
    let first = header.first().cloned().unwrap_or_default();
    if first != "time" {
        return Err(TableError::NoTime(first));
    }
    let mut places = Vec::new();
    for column in &header[1..] {
        let unknown = || TableError::Column { found: column.clone(), expected: names.join(", ") };
        let place = names.iter().position(|name| name == column).ok_or_else(unknown)?;
        if places.contains(&place) {
            return Err(TableError::Twice(column.clone()));
        }
        places.push(place);
    }
    let ties = mechanism.ties();
    let (mut times, mut lines, mut rows) = (Vec::new(), Vec::new(), Vec::new());
    for record in reader.records() {
        let record = record?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut numbers = Vec::new();
        for (column, field) in header.iter().zip(&record) {
            let found = field.parse::<f64>().ok().filter(|x| (-1e6..=1e6).contains(x));
            let wrong = || (column.clone(), field.to_owned());
            numbers.push(
                found.ok_or_else(wrong).map_err(|(column, found)| TableError::Number {
                    line,
                    column,
                    found,
                })?,
            );
        }
        let mut q = mechanism.home();
        for (place, number) in places.iter().zip(&numbers[1..]) {
            q[*place] = *number;
        }
        fill_tied(&ties, &places, &mut q);
        times.push(numbers[0]);
        lines.push(line);
        rows.push(q);
    }
    if times.len() < 2 {
        return Err(MotionError::Rows(times.len()).into());
    }
    let start_s = times[0];
    let step = (times[times.len() - 1] - start_s) / (times.len() - 1) as f64;
    for (row, (found, line)) in times.iter().zip(&lines).enumerate() {
        let expected = start_s + row as f64 * step;
        // The tolerance of 1 % of a step allows for rounded times.
        if (found - expected).abs() > 0.01 * step.abs() + 1e-6 {
            return Err(TableError::Uneven { line: *line, expected, step, found: *found });
        }
    }
    let motion = RigMotion { dt_s: step, rows };
    motion.check(mechanism)?;
    Ok((motion, start_s))
}

/// Sets the coordinates of tied joints without a column, by those with a column (`given`).
fn fill_tied(ties: &Ties, given: &[usize], q: &mut [f64]) {
    for tie in ties.each() {
        let [own, leader] = tie.places();
        let other_gives = ties
            .each()
            .find(|other| other.leader == tie.leader && given.contains(&other.places()[0]));
        if !given.contains(&leader)
            && let Some(other) = other_gives
        {
            q[leader] = other.leader_position(q[other.places()[0]]);
        }
        if !given.contains(&own) {
            q[own] = tie.factor * q[leader] + tie.offset;
        }
    }
}

/// Appends a number with nine decimals, and without a negative zero.
fn number(text: &mut String, value: f64) {
    write!(text, "{:.9}", value + 0.0).expect("a string takes everything");
}

/// Returns a name as a field of CSV.
fn quoted(name: &str) -> String {
    if name.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}
