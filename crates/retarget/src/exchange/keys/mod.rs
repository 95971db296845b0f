//! Reads tables of keys: times of any spacing, joints by name, units in the header, and easings.
//!
//! A table is CSV with commas, semicolons or tabs. The column `time` is in s (`time_ms` in ms); a joint has the column
//! `NAME_deg` or `NAME_rad`, a slide `NAME_mm` or `NAME_m`. An empty field is not a key: the joint moves on to its next
//! key. A joint without a column stays at home. The column `easing` names the easing from each row to the next; a row
//! below the header with `easing` as its time names the easing of each joint.

mod easing;
mod error;
mod header;
mod sheet;
#[cfg(test)]
mod tests;
mod track;

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::columns::{Column, HeaderUnits, Quantity, Unit, columns};
use super::tied::fill_tied;
use crate::feasibility::{Curve, Instant, MotionError, Performance as _, RigMotion};
pub use easing::Easing;
pub use error::KeyError;
use header::{Content, contents};
use sheet::Sheet;
use track::{Key, Track};

/// Rate of a motion that is made from keys, Hz. If the mean time between the keys is less than its time step, the rate
/// is higher.
const RATE_HZ: f64 = 100.0;
/// The highest rate of such a motion, Hz.
const RATE_MAX_HZ: f64 = 1000.0;
/// Largest time step of a recording, s. Rows with a larger step are keys.
const RECORDED_STEP_S: f64 = 0.1;
/// Longest motion that is read, s.
const DURATION_MAX_S: f64 = 7200.0;
/// Speed of the easing `step` for joints without a speed limit, rad/s; the second constant is for slides, m/s.
const STEP_SPEED: f64 = 12.0;
const STEP_SPEED_M_S: f64 = 1.0;

/// A motion that was read.
#[derive(Debug, Clone)]
pub struct KeyedMotion {
    /// The motion, evenly spaced.
    pub motion: RigMotion,
    /// Time of the first row, s.
    pub start_s: f64,
    /// Number of rows, if they are keys; `None` for a recording.
    pub keys: Option<usize>,
    /// For each joint with changes that are faster than its maximum speed: the fastest such change.
    pub jumps: Vec<Jump>,
    /// Indices of the coordinates that the file gives; `None` if it gives all.
    pub given: Option<Vec<usize>>,
    /// Whether the motion is a loop.
    pub is_loop: bool,
}

/// A change from a key to the next that is faster than the joint's maximum speed.
#[derive(Debug, Clone, PartialEq)]
pub struct Jump {
    /// Name of the column without unit.
    pub joint: String,
    /// Line of the later key.
    pub line: u64,
    /// Change of the joint, in `unit`.
    pub change: f64,
    /// Duration of the change, s.
    pub span_s: f64,
    /// Limit of the joint, in `unit` per s.
    pub limit: f64,
    /// Unit of the header.
    pub unit: Unit,
    /// Number of changes of this joint that are too fast.
    pub count: usize,
}

impl std::fmt::Display for Jump {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { joint, line, change, span_s, limit, unit, count } = self;
        let speed = change / span_s;
        write!(
            f,
            "line {line}: {joint} moves by {change:.4} {unit} in {span_s:.3} s, which is {speed:.4} {unit}/s; its limit is \
             {limit:.4} {unit}/s ({count} such change(s))"
        )
    }
}

/// A coordinate with keys.
struct Keyed {
    place: usize,
    unit: Option<Unit>,
    /// Easing of its column, from the row below the header; `None` if there is no such row, or its field is empty.
    easing: Option<Easing>,
    track: Track,
}

/// Reads a table. `units` are those of columns without a unit.
///
/// Evenly spaced rows at 10 Hz or more, without easings and empty fields, are a recording: the motion consists of these
/// rows, resampled if shows cannot have their rate. Other rows are keys, and the motion passes through them.
///
/// # Errors
/// [`KeyError`] names line, column, joint and unit.
pub fn read(
    mechanism: &Mechanism,
    text: &str,
    units: Option<HeaderUnits>,
) -> Result<KeyedMotion, KeyError> {
    if mechanism.bodies.iter().any(|link| link.joint == JointModel::Free) {
        return Err(KeyError::Travels);
    }
    let columns = columns(mechanism);
    let sheet = Sheet::read(text)?;
    let contents = contents(&sheet.header, &columns, units)?;
    let (times_s, keyed, has_easing) = keys(mechanism, &sheet, &contents, &columns)?;
    if times_s.len() < 2 {
        return Err(MotionError::Rows(times_s.len()).into());
    }
    let (start_s, rows) = (times_s[0], times_s.len());
    let duration_s = times_s[rows - 1] - start_s;
    if duration_s > DURATION_MAX_S {
        return Err(KeyError::TooLong(duration_s));
    }
    let jumps = keyed.iter().filter_map(|keyed| keyed.jump(&columns, mechanism)).collect();
    let (ties, given) =
        (mechanism.ties(), keyed.iter().map(|keyed| keyed.place).collect::<Vec<_>>());
    let is_whole = keyed.iter().all(|keyed| keyed.track.keys.len() == rows);
    if let Some(dt_s) = even_step_s(&times_s).filter(|_| is_whole && !has_easing) {
        let row = |row: usize| {
            let mut q = mechanism.home();
            for Keyed { place, track, .. } in &keyed {
                q[*place] = track.keys[row].value;
            }
            fill_tied(&ties, &given, &mut q);
            q
        };
        let motion = RigMotion { dt_s, rows: (0..rows).map(row).collect() };
        let motion = if is_rate_of_shows(dt_s) { motion } else { resampled(mechanism, &motion)? };
        motion.check(mechanism)?;
        let (given, is_loop) = (Some(given), false);
        return Ok(KeyedMotion { motion, start_s, keys: None, jumps, given, is_loop });
    }
    let rate_hz = rate_hz(duration_s / (rows - 1) as f64);
    let at = |time_s: f64| {
        let mut q = mechanism.home();
        for Keyed { place, track, .. } in &keyed {
            q[*place] = track.at(time_s + start_s);
        }
        fill_tied(&ties, &given, &mut q);
        to_unit_length(mechanism, &mut q);
        q
    };
    let rows_s = times(duration_s, rate_hz);
    let motion = RigMotion { dt_s: rate_hz.recip(), rows: rows_s.map(at).collect() };
    motion.check(mechanism)?;
    let (given, is_loop) = (Some(given), false);
    Ok(KeyedMotion { motion, start_s, keys: Some(rows), jumps, given, is_loop })
}

/// Reads the times of the rows and the keys of each coordinate. Returns also whether the table has easings.
fn keys(
    mechanism: &Mechanism,
    sheet: &Sheet,
    contents: &[Content],
    columns: &[Column],
) -> Result<(Vec<f64>, Vec<Keyed>, bool), KeyError> {
    let mut has_easing = contents.contains(&Content::Easing);
    let at_time = contents.iter().position(|content| matches!(content, Content::Time(_)));
    let at_time = at_time.unwrap_or_default();
    let of_joints: Vec<usize> = (0..contents.len())
        .filter(|index| matches!(contents[*index], Content::Coordinate(..)))
        .collect();
    let mut keyed: Vec<Keyed> = Vec::new();
    for index in &of_joints {
        let Content::Coordinate(place, unit) = contents[*index] else { continue };
        let link = &mechanism.bodies[columns[place].body];
        let default =
            if columns[place].quantity == Quantity::Length { STEP_SPEED_M_S } else { STEP_SPEED };
        let speed = if link.speed.is_finite() { link.speed } else { default };
        let track = Track { keys: Vec::new(), speed, acceleration: link.acceleration };
        keyed.push(Keyed { place, unit, easing: None, track });
    }
    let easing = |line: u64, index: usize, found: &str| {
        let wrong = || KeyError::Easing {
            line,
            column: sheet.header[index].clone(),
            found: found.to_owned(),
        };
        (!found.is_empty()).then(|| Easing::named(found).ok_or_else(wrong)).transpose()
    };
    let number = |line: u64, index: usize, what: String, found: &str| {
        sheet.number(found).ok_or_else(|| KeyError::Number {
            line,
            column: sheet.header[index].clone(),
            what,
            found: found.to_owned(),
        })
    };
    let mut times_s: Vec<f64> = Vec::new();
    for row in &sheet.rows {
        let (line, fields) = (row.line, &row.fields);
        if times_s.is_empty() && fields[at_time].eq_ignore_ascii_case("easing") {
            has_easing = true;
            for (keyed, index) in keyed.iter_mut().zip(&of_joints) {
                keyed.easing = easing(line, *index, &fields[*index])?;
            }
            continue;
        }
        let (mut time_s, mut of_row) = (0.0, None);
        for (index, content) in contents.iter().enumerate() {
            match content {
                Content::Time(factor) => {
                    time_s = factor * number(line, index, "the time".to_owned(), &fields[index])?;
                }
                Content::Easing => of_row = easing(line, index, &fields[index])?,
                Content::Coordinate(..) => {}
            }
        }
        if let Some(before) = times_s.last().filter(|before| time_s <= **before) {
            return Err(KeyError::Order { line, before: *before, found: time_s });
        }
        times_s.push(time_s);
        for (keyed, index) in keyed.iter_mut().zip(&of_joints) {
            let field = &fields[*index];
            if field.is_empty() {
                continue;
            }
            let name = &mechanism.bodies[columns[keyed.place].body].joint_name;
            let unit = keyed.unit.map_or(String::new(), |unit| format!(" in {unit}"));
            let number = number(line, *index, format!("joint `{name}`{unit}"), field)?;
            let value = keyed.unit.map_or(number, |unit| unit.to_si(number));
            let easing = of_row.or(keyed.easing).unwrap_or_default();
            keyed.track.keys.push(Key { time_s, value, easing, line });
        }
    }
    for (keyed, index) in keyed.iter().zip(&of_joints) {
        if keyed.track.keys.is_empty() && !times_s.is_empty() {
            return Err(KeyError::Empty(sheet.header[*index].clone()));
        }
    }
    balls(mechanism, columns, &mut keyed)?;
    Ok((times_s, keyed, has_easing))
}

/// Checks that a ball joint has all four numbers in each row, and makes their signs consistent, since a quaternion and
/// its negative are one rotation.
fn balls(mechanism: &Mechanism, columns: &[Column], keyed: &mut [Keyed]) -> Result<(), KeyError> {
    for (body, link) in mechanism.bodies.iter().enumerate() {
        let of_ball: Vec<usize> = (0..keyed.len())
            .filter(|index| columns[keyed[*index].place].body == body)
            .filter(|_| link.joint == JointModel::Spherical)
            .collect();
        let Some(first) = of_ball.first().copied() else { continue };
        let lines = |index: usize| keyed[index].track.keys.iter().map(|key| key.line);
        let part = of_ball.iter().find(|index| !lines(**index).eq(lines(first)));
        if of_ball.len() != 4 || part.is_some() {
            let line = lines(first).next().unwrap_or(1);
            return Err(KeyError::PartOfBall { line, joint: link.joint_name.clone() });
        }
        for row in 1..keyed[first].track.keys.len() {
            let value = |index: &usize, row: usize| keyed[*index].track.keys[row].value;
            let dot: f64 = of_ball.iter().map(|part| value(part, row - 1) * value(part, row)).sum();
            if dot < 0.0 {
                for part in &of_ball {
                    keyed[*part].track.keys[row].value *= -1.0;
                }
            }
        }
    }
    Ok(())
}

impl Keyed {
    /// Returns the fastest change that exceeds the joint's maximum speed; `None` if no change does, and for ball
    /// joints.
    fn jump(&self, columns: &[Column], mechanism: &Mechanism) -> Option<Jump> {
        let (unit, column) = (self.unit?, &columns[self.place]);
        let limit = mechanism.bodies[column.body].speed;
        let worst = self.track.too_fast(limit).max_by(|a, b| a.speed.total_cmp(&b.speed))?;
        let [from, to] = [self.track.keys[worst.to - 1], self.track.keys[worst.to]];
        Some(Jump {
            joint: column.name.clone(),
            line: to.line,
            change: unit.of_si((to.value - from.value).abs()),
            span_s: to.time_s - from.time_s,
            limit: unit.of_si(limit),
            unit,
            count: self.track.too_fast(limit).count(),
        })
    }
}

/// Returns the time step, s, if the times are evenly spaced, at 10 Hz or more.
fn even_step_s(times_s: &[f64]) -> Option<f64> {
    let steps = (times_s.len() - 1) as f64;
    let step_s = (times_s[times_s.len() - 1] - times_s[0]) / steps;
    let is_even = times_s.iter().enumerate().all(|(row, found_s)| {
        let expected_s = times_s[0] + row as f64 * step_s;
        // The tolerance of 1 % of a step, and of 0.5 ms for steps of 25 ms and more, allows for rounded times.
        (found_s - expected_s).abs() <= 0.01 * step_s + f64::min(5e-4, 0.02 * step_s) + 1e-6
    });
    (is_even && step_s <= RECORDED_STEP_S + 1e-9).then_some(step_s)
}

/// Returns whether a show can have this time step: a whole number of samples in 1 s, or in 1001 s, as in television.
fn is_rate_of_shows(dt_s: f64) -> bool {
    let hz = dt_s.recip();
    [hz, 1001.0 * hz].iter().any(|samples| (samples - samples.round()).abs() < 1e-6 * samples)
}

/// Returns the rate, Hz, for keys with the mean time step `step_s`.
fn rate_hz(step_s: f64) -> f64 {
    step_s.recip().ceil().clamp(RATE_HZ, RATE_MAX_HZ)
}

/// Returns the times of rows from 0 until a duration is reached, s.
fn times(duration_s: f64, rate_hz: f64) -> impl Iterator<Item = f64> {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
    let last = (duration_s * rate_hz - 1e-6).ceil().max(1.0) as usize;
    (0..=last).map(move |row| row as f64 / rate_hz)
}

/// Resamples a recording at a rate that shows can have.
fn resampled(mechanism: &Mechanism, motion: &RigMotion) -> Result<RigMotion, MotionError> {
    let (curve, rate_hz) = (Curve::new(mechanism, motion)?, rate_hz(motion.dt_s));
    let at = |time_s: f64| {
        let mut instant = Instant::default();
        curve.at(time_s, &mut instant);
        instant.q
    };
    let rows = times(curve.duration_s(), rate_hz).map(at).collect();
    Ok(RigMotion { dt_s: rate_hz.recip(), rows })
}

/// Scales the quaternions of ball joints to unit length.
fn to_unit_length(mechanism: &Mechanism, q: &mut [f64]) {
    for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
        if link.joint == JointModel::Spherical {
            let length = q[range.clone()].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[range].iter_mut().for_each(|x| *x /= length);
        }
    }
}
