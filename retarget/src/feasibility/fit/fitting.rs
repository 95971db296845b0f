//! A motion on its way to a fit: round by round it is looked at, slowed down and lowered.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::Freedom;

use super::course::{Course, smoothly_less};
use super::joint::{distance, draw};
use super::rest::Rest;
use super::within::Within;
use super::{Fit, FitError, FitSettings, Lowered, Smoothed, interpolated, smooth};
use crate::feasibility::check::{CheckError, Excess, Kind, Report, check};
use crate::feasibility::curve::{Curve, Instant, Performance, align_quaternions};
use crate::feasibility::efforts::Efforts;
use crate::feasibility::limits::{FreedomLimits, Limits};
use crate::feasibility::motion::RigMotion;

/// How long before and after an instant poses are drawn towards home too, s.
const LOWERING_S: f64 = 0.4;
/// Share of its effort that may hold a joint where it is asked for more.
const MOST_HELD: f64 = 0.9;
/// What is drawn of a hot drive's motion in a round.
const COOLING: f64 = 0.97;
/// Slower than this share of its speed, or nearer to home than this share of its way, is no performance any more.
const LEAST_SHARE: f64 = 0.02;

/// What a round has come to.
pub(super) enum Round {
    /// Nothing is exceeded.
    Within,
    /// Something is, by less than before.
    Nearer,
    /// What is left is no performance any more.
    Hopeless,
}

/// A motion on its way to a fit.
pub(super) struct Fitting<'a> {
    mechanism: &'a Mechanism,
    limits: &'a Limits,
    /// What poses are drawn towards: home, where that is light enough.
    rest: &'a Rest,
    settings: FitSettings,
    dt_s: f64,
    /// The rows within their ranges, low-passed.
    rows: Vec<Vec<f64>>,
    within: Within,
    course: Course,
    /// Of each joint the share of its way from home at each row; empty where it is whole.
    share: Vec<Vec<f64>>,
    smoothed: Vec<Smoothed>,
    efforts: Efforts,
}

impl<'a> Fitting<'a> {
    pub(super) fn new(
        mechanism: &'a Mechanism,
        limits: &'a Limits,
        rest: &'a Rest,
        motion: &RigMotion,
        settings: FitSettings,
    ) -> Result<Self, FitError> {
        let mut rows = motion.rows.clone();
        align_quaternions(&mechanism.coordinate_ranges(), &mut rows);
        let mut within = Within::new(mechanism, settings.room);
        for row in &mut rows {
            within.bring(limits, row);
        }
        Ok(Self {
            mechanism,
            limits,
            rest,
            settings,
            dt_s: motion.dt_s,
            course: Course::new(motion.dt_s, rows.len()),
            rows,
            within,
            share: vec![Vec::new(); mechanism.bodies.len()],
            smoothed: Vec::new(),
            efforts: Efforts::of(mechanism).map_err(CheckError::Tree)?,
        })
    }

    /// Low-passes joints that are too fast, as far as that changes little.
    pub(super) fn smooth(&mut self) -> Result<(), FitError> {
        let given = self.rows.clone();
        let mut widest: Vec<Option<(f64, f64)>> = vec![None; self.share.len()];
        let mut ended = vec![false; self.share.len()];
        for width_s in smooth::WIDTHS_S {
            let motion = RigMotion { dt_s: self.dt_s, rows: self.rows.clone() };
            let curve = Curve::new(self.mechanism, &motion)?;
            let report = check(self.mechanism, self.limits, &curve, self.settings.rate_hz)?;
            let is_fast = |excess: &&Excess| {
                matches!(excess.kind, Kind::Speed | Kind::Acceleration | Kind::Effort)
            };
            let mut wanted: Vec<usize> = report
                .excesses
                .iter()
                .filter(is_fast)
                .map(|excess| self.limits.freedoms[excess.freedom].joint)
                .filter(|joint| !ended[*joint])
                .collect();
            wanted.sort_unstable();
            wanted.dedup();
            if wanted.is_empty() {
                break;
            }
            for joint in wanted {
                let sigma = width_s / self.dt_s;
                let (rows, most) = (&mut self.rows, self.settings.change);
                match smooth::smooth(self.mechanism, joint, &given, rows, sigma, most) {
                    Some(change) => widest[joint] = Some((width_s, change)),
                    None => ended[joint] = true,
                }
            }
        }
        self.smoothed = (0..widest.len())
            .filter_map(|joint| {
                let (width_s, change) = widest[joint]?;
                Some(Smoothed { joint: self.name(joint), width_s, change })
            })
            .collect();
        Ok(())
    }

    /// One round: looks where the motion as it is now exceeds a limit, and slows or lowers it there.
    pub(super) fn round(&mut self) -> Result<Round, FitError> {
        let (curve, given_s) = self.curve()?;
        let report = check(self.mechanism, self.limits, &curve, self.settings.rate_hz)?;
        if report.excesses.is_empty() {
            return Ok(Round::Within);
        }
        self.widen(&report);
        let (pace, mut share) = self.look(&curve, &given_s)?;
        for excess in report.excesses.iter().filter(|excess| excess.kind == Kind::Heat) {
            for row in 0..self.rows.len() {
                self.lower_chain(&mut share, excess.freedom, row, COOLING);
            }
        }
        self.course.slow_down(&pace);
        for (now, wanted) in self.share.iter_mut().zip(share) {
            if wanted.is_empty() {
                continue;
            }
            if now.is_empty() {
                *now = vec![1.0; wanted.len()];
            }
            *now = smoothly_less(now, &wanted, LOWERING_S / self.dt_s);
        }
        let least = self.course.pace.iter().chain(self.share.iter().flatten());
        let is_hopeless = least.copied().fold(1.0, f64::min) < LEAST_SHARE;
        Ok(if is_hopeless { Round::Hopeless } else { Round::Nearer })
    }

    /// Stays farther from the ends of ranges that the curve goes beyond: it swings out where rows stop at an end.
    fn widen(&mut self, report: &Report) {
        let is_range = |excess: &&Excess| matches!(excess.kind, Kind::Range | Kind::LinkedRange);
        let mut is_crowded = false;
        for excess in report.excesses.iter().filter(is_range) {
            self.within.widen(
                self.limits.freedoms[excess.freedom].joint,
                (excess.value - excess.limit).abs(),
            );
            is_crowded = true;
        }
        if is_crowded {
            for row in &mut self.rows {
                self.within.bring(self.limits, row);
            }
        }
    }

    /// What share of its speed the motion may have at each given row, and of each joint what share of its way from
    /// home; empty where it is whole. It looks as often as the check: a peak may lie between two rows.
    fn look(
        &mut self,
        curve: &Curve,
        given_s: &[f64],
    ) -> Result<(Vec<f64>, Vec<Vec<f64>>), FitError> {
        let last = self.rows.len() - 1;
        let mut slower = vec![1.0; self.rows.len()];
        let mut lower = vec![Vec::new(); self.share.len()];
        let (mut instant, mut still) = (Instant::default(), Instant::default());
        let (mut efforts, mut holding) = (Vec::new(), Vec::new());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let looks = (curve.duration_s() * self.settings.rate_hz).ceil() as usize;
        for look in 0..=looks {
            let time_s = (look as f64 / self.settings.rate_hz).min(curve.duration_s());
            let given = interpolated(given_s, time_s / self.dt_s) / self.dt_s;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows")]
            let rows = [given.floor(), given.ceil()].map(|row| (row as usize).min(last));
            curve.at(time_s, &mut instant);
            still.q.clone_from(&instant.q);
            still.qd.resize(instant.qd.len(), 0.0);
            still.qdd.resize(instant.qdd.len(), 0.0);
            for (instant, efforts) in [(&instant, &mut efforts), (&still, &mut holding)] {
                self.efforts
                    .at(instant, efforts)
                    .map_err(|source| CheckError::Instant { time_s, source })?;
            }
            for (freedom, limits) in self.limits.freedoms.iter().enumerate() {
                // Friction is the same however slow the course is.
                let dry = self.efforts.dry_friction(freedom, instant.qd[freedom]);
                let (effort, held) = (efforts[freedom], holding[freedom] + dry);
                let (qd, qdd) = (instant.qd[freedom], instant.qdd[freedom]);
                let most = self.most_held(freedom);
                let is_heavy = effort.abs().max(held.abs()) > limits.effort && held.abs() > most;
                let pace = pace(limits, [qd, qdd], (!is_heavy).then_some([effort, held]));
                for row in rows {
                    slower[row] = f64::min(slower[row], pace);
                    if is_heavy {
                        self.lower_chain(&mut lower, freedom, row, ratio(held, most));
                    }
                }
            }
        }
        Ok((slower, lower))
    }

    /// What may hold a freedom where it is asked for more than it gives: with less left for motion, slower is no help.
    fn most_held(&self, freedom: usize) -> f64 {
        let limit = self.limits.freedoms[freedom].effort;
        (MOST_HELD * limit).max(0.5 * (self.rest.holding[freedom].abs() + limit))
    }

    /// Draws a freedom's joint towards rest at a row, with the joints that it carries and that carry it.
    fn lower_chain(&self, lower: &mut [Vec<f64>], freedom: usize, row: usize, share: f64) {
        let joint = self.limits.freedoms[freedom].joint;
        for (other, (link, lower)) in self.mechanism.bodies.iter().zip(lower).enumerate() {
            let in_chain =
                self.mechanism.supports(joint, other) || self.mechanism.supports(other, joint);
            // A base is no joint that could be drawn anywhere.
            if in_chain && !matches!(link.joint, Freedom::Free | Freedom::Fixed) {
                if lower.is_empty() {
                    *lower = vec![1.0; self.rows.len()];
                }
                lower[row] = lower[row].min(share);
            }
        }
    }

    /// The motion as it is now, in its own time, and the given time of each of its rows.
    pub(super) fn curve(&mut self) -> Result<(Curve, Vec<f64>), FitError> {
        let (motion, given_s) = self.motion()?;
        Ok((Curve::new(self.mechanism, &motion)?, given_s))
    }

    fn motion(&mut self) -> Result<(RigMotion, Vec<f64>), FitError> {
        let mut rows = self.rows.clone();
        let ranges = self.mechanism.coordinate_ranges();
        for (share, range) in self.share.iter().zip(ranges).filter(|(share, _)| !share.is_empty()) {
            for (row, share) in rows.iter_mut().zip(share) {
                draw(&mut row[range.clone()], &self.rest.q[range.clone()], *share);
            }
        }
        // A joint that was changed alone may have left its ties.
        for row in &mut rows {
            self.within.bring(self.limits, row);
        }
        let still = RigMotion { dt_s: self.dt_s, rows };
        let Some(given_s) = self.course.given_s() else {
            let given_s = (0..still.rows.len()).map(|row| row as f64 * self.dt_s).collect();
            return Ok((still, given_s));
        };
        let given = Curve::new(self.mechanism, &still)?;
        let mut instant = Instant::default();
        let rows = given_s.iter().map(|time_s| {
            given.at(*time_s, &mut instant);
            instant.q.clone()
        });
        Ok((RigMotion { dt_s: self.dt_s, rows: rows.collect() }, given_s))
    }

    pub(super) fn done(mut self) -> Result<Fit, FitError> {
        let (motion, given_s) = self.motion()?;
        let least = |values: &[f64]| {
            let rows = values.iter().copied().enumerate();
            let least = rows.min_by(|a, b| a.1.total_cmp(&b.1));
            least.map_or((1.0, 0.0), |(row, least)| (least, row as f64 * self.dt_s))
        };
        let lowered = self.share.iter().enumerate().filter(|(_, share)| !share.is_empty());
        let clamped = self.within.clamped.iter().enumerate().filter(|(_, change)| **change > 0.0);
        Ok(Fit {
            motion,
            given_s,
            slowest: least(&self.course.pace),
            lowered: lowered
                .map(|(joint, share)| {
                    let (share, at_s) = least(share);
                    Lowered { joint: self.name(joint), share, at_s }
                })
                .collect(),
            clamped: clamped.map(|(joint, change)| (self.name(joint), *change)).collect(),
            lightened: if self.share.iter().all(Vec::is_empty) { vec![] } else { self.lightened() },
            smoothed: std::mem::take(&mut self.smoothed),
        })
    }

    /// The joints of the pose that is drawn towards which are not at home.
    fn lightened(&self) -> Vec<(String, f64)> {
        let home = self.mechanism.home();
        let ranges = self.mechanism.coordinate_ranges();
        let changes =
            ranges.into_iter().map(|range| distance(&self.rest.q[range.clone()], &home[range]));
        let changes = changes.enumerate().filter(|(_, change)| *change > 0.0);
        changes.map(|(joint, change)| (self.name(joint), change)).collect()
    }

    fn name(&self, joint: usize) -> String {
        self.mechanism.bodies[joint].joint_name.clone()
    }
}

/// What share of its speed a motion may have for one freedom: of its speed and acceleration, and, if slower helps, of
/// its effort and the part of that which is there however slow it goes.
fn pace(limits: &FreedomLimits, [qd, qdd]: [f64; 2], efforts: Option<[f64; 2]>) -> f64 {
    let of_motion = ratio(qd, limits.speed).min(libm::sqrt(ratio(qdd, limits.acceleration)));
    let Some([effort, held]) = efforts.filter(|[effort, _]| effort.abs() > limits.effort) else {
        return of_motion;
    };
    // What is left for motion beside gravity and friction.
    let moving = effort - held;
    let left = (limits.effort - held * moving.signum()).max(0.0);
    of_motion.min(libm::sqrt(ratio(moving, left)))
}

/// The share of a value that a limit allows, at most 1.
fn ratio(value: f64, limit: f64) -> f64 {
    (limit / value.abs()).min(1.0)
}
