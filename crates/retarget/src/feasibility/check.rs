//! Finds the places where a motion exceeds the limits of a rig.

use std::ops::Range;

use sinew_rig::Mechanism;

use super::curve::{Instant, Performance};
use super::efforts::{Block, Efforts};
use super::error::CheckError;
use super::limits::Limits;
use super::report::{DofPeaks, Excess, Kind, Report};

/// Two excesses with a smaller gap between them are combined to one, s.
const GAP_S: f64 = 0.1;

/// Returns the smallest rate, at least `rate_hz`, whose samples include every row of a motion, because a curve's
/// accelerations are largest at rows. The other samples are spaced evenly between rows.
pub fn rate_at_rows(rate_hz: f64, dt_s: f64) -> f64 {
    (rate_hz * dt_s - 1e-6).ceil().max(1.0) / dt_s
}

/// Samples a motion `rate_hz` times per second. Positions, speeds and accelerations are those of the performance;
/// efforts are those of the core's inverse dynamics with rotors and friction. O(duration · rate · bodies).
///
/// # Errors
/// [`CheckError`] if the rate is not from 10 to 10,000 Hz, the rig exceeds the core's capacity, or an instant is
/// invalid for the rig.
pub fn check(
    mechanism: &Mechanism,
    limits: &Limits,
    performance: &impl Performance,
    rate_hz: f64,
) -> Result<Report, CheckError> {
    // The comparison also refuses NaN.
    if !(10.0..=10_000.0).contains(&rate_hz) {
        return Err(CheckError::Rate(rate_hz));
    }
    let mut efforts = Efforts::of(mechanism)?;
    let mut tally = Tally::new(mechanism, limits, rate_hz);
    let duration_s = performance.duration_s();
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "not negative")]
    let count = (duration_s * rate_hz).ceil() as usize;
    let mut times_s = (0..=count).map(|index| (index as f64 / rate_hz).min(duration_s));
    let mut block = Block::default();
    while block.next(performance, &mut times_s) {
        block.find_efforts(&mut efforts)?;
        for (time_s, instant, efforts) in block.each() {
            tally.take(time_s, instant, efforts);
        }
    }
    Ok(tally.report(duration_s, count + 1))
}

/// Values accumulated over the instants so far.
pub(super) struct Tally<'a> {
    limits: &'a Limits,
    /// Dofs whose excesses `take` reports; `None` for all dofs.
    pub(super) watched: Option<&'a [bool]>,
    dt_s: f64,
    /// Index in `q` of each dof's position; `None` for ball joints and a driven base.
    places: Vec<Option<usize>>,
    /// Range in `q` of each body's coordinates, and its first dof.
    joints: Vec<(Range<usize>, usize)>,
    /// Low-passed squares of efforts, a measure of heat.
    heat: Vec<f64>,
    squares: Vec<f64>,
    peaks: Vec<DofPeaks>,
    excesses: Vec<Excess>,
    /// Index in `excesses` of the last excess of a dof and kind.
    open: Vec<[Option<usize>; Kind::COUNT]>,
}

impl<'a> Tally<'a> {
    pub(super) fn new(mechanism: &Mechanism, limits: &'a Limits, rate_hz: f64) -> Self {
        let (mut places, mut joints) = (Vec::new(), Vec::new());
        for (link, range) in mechanism.bodies.iter().zip(mechanism.coordinate_ranges()) {
            let count = link.joint.kind().dof_count();
            let scalar = range.len() == count;
            let first = places.len();
            places.extend((0..count).map(|axis| scalar.then_some(range.start + axis)));
            joints.push((range, first));
        }
        let dofs = places.len();
        let peaks =
            DofPeaks { least: f64::INFINITY, most: f64::NEG_INFINITY, ..DofPeaks::default() };
        Self {
            limits,
            watched: None,
            dt_s: rate_hz.recip(),
            places,
            joints,
            heat: vec![0.0; dofs],
            squares: vec![0.0; dofs],
            peaks: vec![peaks; dofs],
            excesses: Vec::new(),
            open: vec![[None; Kind::COUNT]; dofs],
        }
    }

    /// Processes an instant and its efforts. Returns whether a speed, an acceleration or an effort of a watched dof
    /// exceeds its limit.
    pub(super) fn take(&mut self, time_s: f64, instant: &Instant, efforts: &[f64]) -> bool {
        let limits = self.limits;
        let mut is_beyond = false;
        for (dof, (limits, effort)) in limits.dofs.iter().zip(efforts).enumerate() {
            let (speed, acceleration) = (instant.qd[dof], instant.qdd[dof]);
            let effort = *effort;
            let peaks = &mut self.peaks[dof];
            peaks.speed = peaks.speed.max(speed.abs());
            peaks.acceleration = peaks.acceleration.max(acceleration.abs());
            peaks.effort = peaks.effort.max(effort.abs());
            self.squares[dof] += effort * effort;
            if let Some(place) = self.places[dof] {
                let position = instant.q[place];
                peaks.least = peaks.least.min(position);
                peaks.most = peaks.most.max(position);
                let [least, most] = limits.range;
                let end = if position < least { least } else { most };
                if position < least || position > most {
                    self.note(dof, Kind::Range, time_s, position, end);
                }
            }
            for (kind, value, limit) in [
                (Kind::Speed, speed, limits.speed),
                (Kind::Acceleration, acceleration, limits.acceleration),
                (Kind::Effort, effort, limits.effort),
            ] {
                let beyond = value.abs() > limit;
                if beyond {
                    is_beyond |= self.watched.is_none_or(|watched| watched[dof]);
                    self.note(dof, kind, time_s, value.abs(), limit);
                }
            }
            if let Some(heat) = limits.heat {
                // A low-pass of the square is proportional to the heating of a motor, over its thermal time.
                let share = self.dt_s / heat.time_s;
                self.heat[dof] += (effort * effort - self.heat[dof]) * share.min(1.0);
                let mean = libm::sqrt(self.heat[dof]);
                if mean > heat.continuous {
                    self.note(dof, Kind::Heat, time_s, mean, heat.continuous);
                }
            }
        }
        self.take_joined(time_s, instant);
        is_beyond
    }

    /// Checks rotations of ball joints, and limits that join two joints.
    fn take_joined(&mut self, time_s: f64, instant: &Instant) {
        for (body, most) in &self.limits.turns {
            let (range, dof) = self.joints[*body].clone();
            let Some(&[x, y, z, w]) = instant.q.get(range) else { continue };
            let turn = 2.0 * libm::atan2(libm::sqrt(x * x + y * y + z * z), w.abs());
            if turn > *most {
                self.note(dof, Kind::Range, time_s, turn, *most);
            }
        }
        for linked in &self.limits.linked {
            let place = |body: usize| self.joints[body].0.start;
            let position = |body: usize| instant.q.get(place(body)).copied().unwrap_or(0.0);
            let sum = linked.factor * position(linked.body)
                + linked.other_factor * position(linked.other);
            let [least, most] = linked.range;
            // A sum is computed, therefore rounding errors are allowed.
            let room = 1e-6;
            let end = if sum < least { least } else { most };
            if sum < least - room || sum > most + room {
                self.note(self.joints[linked.body].1, Kind::LinkedRange, time_s, sum, end);
            }
        }
    }

    /// Records that a dof exceeds a limit.
    fn note(&mut self, dof: usize, kind: Kind, time_s: f64, value: f64, limit: f64) {
        let open = &mut self.open[dof][kind as usize];
        if let Some(open) = *open {
            let excess = &mut self.excesses[open];
            if time_s - excess.to_s <= GAP_S {
                excess.to_s = time_s;
                if (value - limit).abs() > (excess.value - excess.limit).abs() {
                    (excess.worst_s, excess.value, excess.limit) = (time_s, value, limit);
                }
                return;
            }
        }
        *open = Some(self.excesses.len());
        self.excesses.push(Excess {
            dof,
            kind,
            from_s: time_s,
            to_s: time_s,
            worst_s: time_s,
            value,
            limit,
        });
    }

    pub(super) fn report(mut self, duration_s: f64, count: usize) -> Report {
        for (peaks, square) in self.peaks.iter_mut().zip(&self.squares) {
            peaks.effort_rms = libm::sqrt(square / count as f64);
            if peaks.least > peaks.most {
                (peaks.least, peaks.most) = (0.0, 0.0);
            }
        }
        // If the motion is repeated, a drive's heat approaches the mean over the whole motion.
        for dof in 0..self.peaks.len() {
            let value = self.peaks[dof].effort_rms;
            let limit = self.limits.dofs[dof].heat.map(|heat| heat.continuous);
            let is_told = self.open[dof][Kind::Heat as usize].is_some();
            if let Some(limit) = limit.filter(|limit| value > *limit && !is_told) {
                let (from_s, to_s, worst_s) = (0.0, duration_s, duration_s);
                self.excesses.push(Excess {
                    dof,
                    kind: Kind::Heat,
                    from_s,
                    to_s,
                    worst_s,
                    value,
                    limit,
                });
            }
        }
        let mut report = Report { duration_s, peaks: self.peaks, excesses: Vec::new() };
        report.add(self.excesses);
        report
    }
}
