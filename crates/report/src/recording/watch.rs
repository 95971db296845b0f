//! Collects the data of a recording for its page, tick by tick.

use std::collections::BTreeMap;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use sinew_performance::play::{Part, SwingMeter};

use crate::traces::{Channel, MOST, pack, spacing};

/// Number of values that a sample of one joint takes on the page: one for each trace, and half a value each for limiter
/// and oscillation.
const WIDTH: usize = 6;

/// Columns of the recording for a joint of the page.
#[derive(Debug, Clone, Copy)]
pub(super) struct Columns {
    pub(super) joint: usize,
    /// Column of the joint's first servo, if a servo moves it.
    pub(super) servo: Option<usize>,
}

/// The data collected from the parts of a recording.
#[derive(Debug)]
pub(super) struct Watch {
    columns: Vec<Columns>,
    rows: usize,
    taken: usize,
    every: usize,
    rate_hz: f64,
    joints: Vec<Joint>,
    limiters: Vec<String>,
    /// States of the supervisor with their start and end, s.
    pub(super) states: Vec<Span>,
    /// Faults and warnings with their times, s.
    pub(super) faults: Vec<(f64, String)>,
}

/// A state of the supervisor, and its time interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Span {
    pub(super) name: String,
    pub(super) from_s: f64,
    pub(super) to_s: f64,
}

#[derive(Debug)]
struct Joint {
    commanded: Vec<f64>,
    measured: Vec<f64>,
    error: Vec<f64>,
    effort: Vec<f64>,
    current: Vec<f64>,
    /// Limiter by sample: its number, counted from 1; 0 for none.
    limiter: Vec<u8>,
    /// Oscillation by sample: 1 if the joint oscillates in it.
    swings: Vec<u8>,
    told: JointSummary,
}

/// Summary of a joint over the ticks in which the show runs.
#[derive(Debug, Clone)]
pub(super) struct JointSummary {
    /// Number of ticks.
    pub(super) ticks: usize,
    /// Sum of the absolute errors, rad or m.
    pub(super) error_sum: f64,
    /// Largest absolute error, rad or m.
    pub(super) error_most: f64,
    /// Time of the largest error, s.
    pub(super) error_most_s: f64,
    /// Largest torque or force, N m or N.
    pub(super) effort: f64,
    /// Largest current of the joint's first servo, A. The next field is its highest temperature, °C.
    pub(super) current_a: f64,
    pub(super) celsius: f64,
    /// Number of limited ticks by limiter.
    pub(super) limited: BTreeMap<String, usize>,
    /// Meter of the part of the error that is faster than a show.
    pub(super) swing: SwingMeter,
    /// Whether the controller detected an oscillation at any time.
    pub(super) is_swinging: bool,
}

impl JointSummary {
    pub(super) fn error_mean(&self) -> f64 {
        self.error_sum / self.ticks.max(1) as f64
    }

    /// Returns the percentage of limited ticks, and the most frequent limiter.
    pub(super) fn limited(&self) -> String {
        let share = 100.0 * self.limited.values().sum::<usize>() as f64 / self.ticks.max(1) as f64;
        let most = self.limited.iter().max_by_key(|(_, count)| **count);
        most.map_or_else(|| "0 %".to_owned(), |(limiter, _)| format!("{share:.0} % {limiter}"))
    }

    fn new(rate_hz: f64) -> Self {
        Self {
            ticks: 0,
            error_sum: 0.0,
            error_most: 0.0,
            error_most_s: 0.0,
            effort: 0.0,
            current_a: 0.0,
            celsius: 0.0,
            limited: BTreeMap::new(),
            swing: SwingMeter::new(rate_hz),
            is_swinging: false,
        }
    }
}

impl Watch {
    /// Creates the collection for a recording with this number of rows.
    pub(super) fn new(columns: Vec<Columns>, rows: usize, rate_hz: f64) -> Self {
        let (looks, every) = spacing(rows.saturating_sub(1), rate_hz, WIDTH * columns.len(), MOST);
        let count = looks / every + 1;
        let joint = || Joint {
            commanded: vec![f64::NAN; count],
            measured: vec![f64::NAN; count],
            error: vec![f64::NAN; count],
            effort: vec![f64::NAN; count],
            current: vec![f64::NAN; count],
            limiter: vec![0; count],
            swings: vec![0; count],
            told: JointSummary::new(rate_hz),
        };
        Self {
            joints: columns.iter().map(|_| joint()).collect(),
            columns,
            rows: 0,
            taken: looks + 1,
            every,
            rate_hz,
            limiters: Vec::new(),
            states: Vec::new(),
            faults: Vec::new(),
        }
    }

    /// Adds the next rows.
    pub(super) fn take(&mut self, part: &Part) {
        for (row, time_s) in part.time_s.iter().enumerate() {
            let name = part.states[row].as_deref().unwrap_or("unknown");
            match self.states.last_mut() {
                Some(last) if last.name == name => last.to_s = *time_s,
                _ => {
                    let name = name.to_owned();
                    self.states.push(Span { name, from_s: *time_s, to_s: *time_s });
                }
            }
            // Faults of one tick are in one cell.
            let faults = part.faults[row].iter().flat_map(|faults| faults.split(", "));
            self.faults.extend(faults.map(|fault| (*time_s, fault.to_owned())));
            for place in 0..self.columns.len() {
                self.take_joint(part, row, place);
            }
            self.rows += 1;
        }
    }

    fn take_joint(&mut self, part: &Part, row: usize, place: usize) {
        let Columns { joint: column, servo } = self.columns[place];
        let (of, joint) = (&part.joints[column], &mut self.joints[place]);
        let [error, effort] = [&of.error, &of.effort].map(|course| f64::from(course[row]));
        let servo = servo.map(|servo| &part.servos[servo]);
        let current = servo.map_or(f64::NAN, |servo| f64::from(servo.current[row]));
        let limited_by = of.limiter[row].as_deref();
        let limiter = limited_by.map_or(0, |name| code(&mut self.limiters, name));
        joint.told.is_swinging |= of.swings[row];
        if part.runs[row] {
            let told = &mut joint.told;
            told.ticks += 1;
            told.error_sum += error.abs();
            if error.abs() > told.error_most {
                (told.error_most, told.error_most_s) = (error.abs(), part.time_s[row]);
            }
            told.effort = told.effort.max(effort.abs());
            told.current_a = told.current_a.max(current.abs());
            let celsius = servo.map_or(f64::NAN, |servo| f64::from(servo.temperature[row]));
            told.celsius = told.celsius.max(celsius);
            if let Some(limiter) = limited_by {
                *told.limited.entry(limiter.to_owned()).or_default() += 1;
            }
            told.swing.note(error);
        }
        if self.rows >= self.taken {
            return;
        }
        let sample = ((self.rows + self.every / 2) / self.every).min(joint.error.len() - 1);
        for (course, now) in
            [(&mut joint.error, error), (&mut joint.effort, effort), (&mut joint.current, current)]
        {
            // A known value always replaces an unknown one.
            if course[sample].is_nan() || now.abs() > course[sample].abs() {
                course[sample] = now;
            }
        }
        if limiter > 0 {
            joint.limiter[sample] = limiter;
        }
        joint.swings[sample] |= u8::from(of.swings[row]);
        if self.rows.is_multiple_of(self.every) {
            let at = self.rows / self.every;
            joint.commanded[at] = of.commanded[row].into();
            joint.measured[at] = of.measured[row].into();
        }
    }

    /// Returns the summaries of the joints.
    pub(super) fn told(&self) -> impl Iterator<Item = &JointSummary> {
        self.joints.iter().map(|joint| &joint.told)
    }

    /// Returns the time between samples, s.
    pub(super) fn dt_s(&self) -> f64 {
        self.every as f64 / self.rate_hz
    }

    /// Returns the time of the last sample, s.
    pub(super) fn end_s(&self) -> f64 {
        (self.count() - 1) as f64 * self.dt_s()
    }

    fn count(&self) -> usize {
        (self.taken - 1) / self.every + 1
    }

    /// Returns the data for the page's script.
    pub(super) fn show(&self) -> Show<'_> {
        let packed = |of: fn(&Joint) -> &Vec<f64>| {
            self.joints.iter().map(|joint| pack(of(joint))).collect::<Vec<_>>()
        };
        Show {
            count: self.count(),
            dt_s: self.dt_s(),
            courses: Traces {
                commanded: packed(|joint| &joint.commanded),
                measured: packed(|joint| &joint.measured),
                error: packed(|joint| &joint.error),
                effort: packed(|joint| &joint.effort),
                current: packed(|joint| &joint.current),
            },
            limiters: &self.limiters,
            limited: self.joints.iter().map(|joint| codes(&joint.limiter)).collect(),
            swings: self.joints.iter().map(|joint| codes(&joint.swings)).collect(),
            states: &self.states,
            faults: self.faults.iter().map(|(at_s, _)| *at_s).collect(),
        }
    }
}

/// Returns the number of a limiter, starting at 1. There are few kinds of limiters; all beyond 255 share one
/// number.
fn code(limiters: &mut Vec<String>, name: &str) -> u8 {
    let place = limiters.iter().position(|known| known == name).unwrap_or_else(|| {
        limiters.push(name.to_owned());
        limiters.len() - 1
    });
    u8::try_from(place + 1).unwrap_or(u8::MAX)
}

/// Encodes bytes as base64; empty if all are 0.
fn codes(bytes: &[u8]) -> String {
    if bytes.iter().all(|code| *code == 0) {
        return String::new();
    }
    STANDARD.encode(bytes)
}

#[derive(Debug, Serialize)]
pub(super) struct Show<'a> {
    count: usize,
    dt_s: f64,
    courses: Traces,
    limiters: &'a [String],
    limited: Vec<String>,
    swings: Vec<String>,
    states: &'a [Span],
    faults: Vec<f64>,
}

/// Traces by joint. A sample of error, effort or current is the value farthest from zero in its ticks.
#[derive(Debug, Serialize)]
struct Traces {
    commanded: Vec<Channel>,
    measured: Vec<Channel>,
    error: Vec<Channel>,
    effort: Vec<Channel>,
    current: Vec<Channel>,
}
