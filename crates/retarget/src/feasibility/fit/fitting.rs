//! A motion on its way to a fit: round by round it is looked at, slowed down and lowered.

use std::ops::Range;

use sinew_rig::Mechanism;

use super::along::Along;
use super::course::{LimitTrace, lessen};
use super::error::FitError;
use super::joint::{distance, draw};
use super::progress::Progress;
use super::rest::Rest;
use super::result::{Fit, FitSettings, LoweredJoint, SmoothedJoint};
use super::scan::{LimitScan, ScanResult, lower_chain, most_held};
use super::smooth;
use super::within::Within;
use crate::feasibility::check::Tally;
use crate::feasibility::curve::{Curve, Performance as _};
use crate::feasibility::efforts::{Block, Efforts};
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::{DofLimits, Limits};
use crate::feasibility::motion::RigMotion;
use crate::feasibility::report::{Excess, Kind, Report};
use crate::feasibility::rows::Rows;

/// How long before and after an instant poses are drawn towards home too, s.
const LOWERING_S: f64 = 0.4;
/// What is drawn of a hot drive's motion in a round.
const COOLING: f64 = 0.97;
/// Slower than this share of its speed, or nearer to home than this share of its way, is no performance any more.
const LEAST_SHARE: f64 = 0.02;
/// Looks beside those that saw an excess at which a smoothed motion is looked at again.
const BESIDE: usize = 2;

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
    /// Of each joint its numbers in a row.
    joints: Vec<Range<usize>>,
    /// The rows within their ranges, low-passed.
    rows: Rows,
    within: Within,
    course: LimitTrace,
    /// Of each joint the share of its way from home at each row; empty where it is whole.
    share: Vec<Vec<f64>>,
    /// Of each joint the widest low-pass: how wide, s, and how much it changed.
    widest: Vec<Option<(f64, f64)>>,
    /// Joints that no wider one may change.
    ended: Vec<bool>,
    efforts: Efforts,
    /// The rows of the motion in given time, as long as neither those above nor shares change.
    still: Option<Rows>,
    /// Dofs that were too fast or too strong in any round.
    fast: Vec<bool>,
}

impl<'a> Fitting<'a> {
    pub(super) fn new(
        mechanism: &'a Mechanism,
        limits: &'a Limits,
        rest: &'a Rest,
        motion: &RigMotion,
        settings: FitSettings,
    ) -> Result<Self, FitError> {
        let mut rows = Rows::of(mechanism.coordinate_count(), &motion.rows);
        let mut within = Within::new(mechanism, settings.room);
        rows.iter_mut().for_each(|row| within.bring(limits, row));
        Ok(Self {
            mechanism,
            limits,
            rest,
            settings,
            dt_s: motion.dt_s,
            joints: mechanism.coordinate_ranges(),
            course: LimitTrace::new(motion.dt_s, rows.count),
            rows,
            within,
            share: vec![Vec::new(); mechanism.bodies.len()],
            widest: vec![None; mechanism.bodies.len()],
            ended: vec![false; mechanism.bodies.len()],
            efforts: Efforts::asked_by(mechanism, limits).map_err(CheckError::Tree)?,
            still: None,
            fast: vec![false; limits.dofs.len()],
        })
    }

    /// Goes on from what was done for another fit of the motion.
    pub(super) fn go_on_from(&mut self, before: &Progress) {
        let Progress { widest, ended, pace, share, room } = before.clone();
        (self.widest, self.ended, self.share) = (widest, ended, share);
        (self.course.pace, self.within.room) = (pace, room);
        self.rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
    }

    /// Low-passes joints that are too fast, as far as that changes little. Whether nothing is exceeded at all.
    pub(super) fn smooth(&mut self) -> Result<bool, FitError> {
        let given = self.rows.clone();
        self.smooth_as_before(&given);
        let (mut report, mut looks) = self.excesses_of_rows(None)?;
        let is_whole = self.course.is_as_given() && self.share.iter().all(Vec::is_empty);
        if report.excesses.is_empty() && is_whole {
            return Ok(true);
        }
        for width_s in smooth::WIDTHS_S {
            let mut wanted: Vec<usize> = report
                .excesses
                .iter()
                .filter(|excess| is_fast(excess))
                .map(|excess| self.limits.dofs[excess.dof].joint)
                .filter(|joint| !self.ended[*joint])
                .collect();
            if wanted.is_empty() {
                break;
            }
            wanted.sort_unstable();
            wanted.dedup();
            // Of those that a fit before has smoothed, the next width is wider.
            wanted.retain(|joint| self.widest[*joint].is_none_or(|(widest, _)| widest < width_s));
            if wanted.is_empty() {
                continue;
            }
            for joint in wanted {
                let sigma = width_s / self.dt_s;
                let (rows, most) = (&mut self.rows, self.settings.change);
                match smooth::smooth(self.mechanism, joint, &given, rows, sigma, most) {
                    Some(change) => self.widest[joint] = Some((width_s, change)),
                    None => self.ended[joint] = true,
                }
            }
            // What a low-pass takes away was there before, and of joints that it may still change: elsewhere the rounds
            // look.
            (report, looks) = self.excesses_of_rows(Some(&looks))?;
        }
        Ok(false)
    }

    /// Low-passes the joints that a fit before has low-passed.
    fn smooth_as_before(&mut self, given: &Rows) {
        for (joint, widest) in self.widest.iter().enumerate() {
            if let Some((width_s, _)) = widest {
                let (sigma, rows) = (width_s / self.dt_s, &mut self.rows);
                smooth::smooth(self.mechanism, joint, given, rows, sigma, f64::INFINITY);
            }
        }
    }

    /// What the rows exceed, at all looks or at some; and beside which looks joints that may still be smoothed are too
    /// fast or too strong.
    fn excesses_of_rows(&mut self, at: Option<&[usize]>) -> Result<(Report, Vec<usize>), FitError> {
        let may_be_smoothed = |limits: &DofLimits| !self.ended[limits.joint];
        let watched: Vec<bool> = self.limits.dofs.iter().map(may_be_smoothed).collect();
        let no_rows = Rows::of(0, &[]);
        let rows = std::mem::replace(&mut self.rows, no_rows);
        let curve = Curve::through(&self.joints, rows, self.dt_s);
        let (duration_s, rate_hz) = (curve.duration_s(), self.settings.rate_hz);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let last = (duration_s * rate_hz).ceil() as usize;
        let mut tally = Tally::new(self.mechanism, self.limits, rate_hz);
        tally.watched = Some(&watched);
        let (mut block, mut beyond) = (Block::default(), Vec::new());
        let count = at.map_or(last + 1, <[usize]>::len);
        let look = |index: usize| at.map_or(index, |at| at[index]);
        let mut times_s = (0..count).map(|index| (look(index) as f64 / rate_hz).min(duration_s));
        let mut seen = 0;
        while block.next(&curve, &mut times_s) {
            block.find_efforts(&mut self.efforts)?;
            for (time_s, instant, efforts) in block.each() {
                if tally.take(time_s, instant, efforts) {
                    let first = beyond.last().map_or(0, |last| last + 1);
                    let look = look(seen);
                    beyond
                        .extend(first.max(look.saturating_sub(BESIDE))..=(look + BESIDE).min(last));
                }
                seen += 1;
            }
        }
        let report = tally.report(duration_s, count);
        self.rows = curve.into_rows();
        Ok((report, beyond))
    }

    /// One round: looks where the motion as it is now exceeds a limit, and slows or lowers it there.
    pub(super) fn round(&mut self) -> Result<Round, FitError> {
        let given_s = self.course.given_s();
        let mut still = self.still_rows();
        // Of a motion as long as the clip there are only so many curves at a time.
        let curve = match &given_s {
            Some(given_s) => {
                let curve = Curve::through(&self.joints, still, self.dt_s);
                let paced = curve.rows_at(given_s.iter().copied());
                still = curve.into_rows();
                Curve::through(&self.joints, paced, self.dt_s)
            }
            None => Curve::through(&self.joints, still.clone(), self.dt_s),
        };
        let looking = LimitScan {
            mechanism: self.mechanism,
            limits: self.limits,
            rest: self.rest,
            efforts: &mut self.efforts,
            rate_hz: self.settings.rate_hz,
            dt_s: self.dt_s,
            rows: self.rows.count,
        };
        let look = looking.at(&curve, given_s.as_deref())?;
        drop((curve, given_s));
        let ScanResult { report, pace, mut share } = look;
        if report.excesses.is_empty() {
            self.still = Some(still);
            return Ok(Round::Within);
        }
        for excess in report.excesses.iter().filter(|excess| excess.kind == Kind::Heat) {
            let joint = self.limits.dofs[excess.dof].joint;
            for row in 0..self.rows.count {
                let rows = [row, self.rows.count];
                lower_chain(self.mechanism, &mut share, joint, rows, COOLING);
            }
        }
        report.excesses.iter().filter(|excess| is_fast(excess)).for_each(|excess| {
            self.fast[excess.dof] = true;
        });
        self.course.slow_down(0, &pace);
        let is_lowered = self.lower(&share);
        if !self.widen(&report) && !is_lowered {
            let curve = Curve::through(&self.joints, still, self.dt_s);
            self.slow_down_along(&curve, &pace)?;
            self.still = Some(curve.into_rows());
        }
        let least = self.course.pace.iter().chain(self.share.iter().flatten());
        let is_hopeless = least.copied().fold(1.0, f64::min) < LEAST_SHARE;
        Ok(if is_hopeless { Round::Hopeless } else { Round::Nearer })
    }

    /// Slows the course down where it was seen to be too fast, as far as is known without another look.
    fn slow_down_along(&mut self, still: &Curve, seen: &[f64]) -> Result<(), FitError> {
        let limits = self.limits;
        let all = self.fast.iter().zip(&limits.dofs).zip(&self.rest.holding).enumerate();
        let dofs: Vec<(usize, f64)> = all
            .filter(|(_, ((is_fast, _), _))| **is_fast)
            .map(|(dof, ((_, limits), held))| (dof, most_held(limits, *held)))
            .collect();
        let mut along = Along {
            curve: still,
            rate_hz: self.settings.rate_hz,
            limits,
            efforts: &mut self.efforts,
            dofs: &dofs,
        };
        Ok(along.slow_down(&mut self.course, seen)?)
    }

    /// Draws joints towards home, by shares of their way at each row; whether any was.
    fn lower(&mut self, share: &[Vec<f64>]) -> bool {
        let mut is_lowered = false;
        for (now, wanted) in self.share.iter_mut().zip(share).filter(|(_, share)| !share.is_empty())
        {
            if now.is_empty() {
                *now = vec![1.0; wanted.len()];
            }
            lessen(now, 0, wanted, LOWERING_S / self.dt_s);
            is_lowered = true;
        }
        is_lowered
    }

    /// Stays farther from the ends of ranges that the curve goes beyond: it swings out where rows stop at an end.
    fn widen(&mut self, report: &Report) -> bool {
        let is_range = |excess: &&Excess| matches!(excess.kind, Kind::Range | Kind::LinkedRange);
        let mut is_crowded = false;
        for excess in report.excesses.iter().filter(is_range) {
            self.within
                .widen(self.limits.dofs[excess.dof].joint, (excess.value - excess.limit).abs());
            is_crowded = true;
        }
        if is_crowded {
            self.rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
        }
        is_crowded
    }

    /// The rows of the motion as it is now, in given time.
    fn still_rows(&mut self) -> Rows {
        if let Some(still) = self.still.take() {
            return still;
        }
        let mut rows = self.rows.clone();
        for (share, range) in self.share.iter().zip(&self.joints).filter(|(s, _)| !s.is_empty()) {
            for (row, share) in rows.iter_mut().zip(share) {
                draw(&mut row[range.clone()], &self.rest.q[range.clone()], *share);
            }
        }
        // A joint that was changed alone may have left its ties.
        rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
        rows
    }

    /// The motion as it is now, in its own time, and the given time of each of its rows, s.
    fn motion(&mut self) -> (Rows, Vec<f64>) {
        let still = self.still_rows();
        let still = Curve::through(&self.joints, still, self.dt_s);
        if let Some(given_s) = self.course.given_s() {
            (still.rows_at(given_s.iter().copied()), given_s)
        } else {
            let given_s = (0..self.rows.count).map(|row| row as f64 * self.dt_s).collect();
            (still.into_rows(), given_s)
        }
    }

    /// The motion as it is now as a curve, and the given time of each of its rows, s.
    pub(super) fn curve(&mut self) -> (Curve, Vec<f64>) {
        let (rows, given_s) = self.motion();
        (Curve::through(&self.joints, rows, self.dt_s), given_s)
    }

    pub(super) fn done(mut self) -> Fit {
        let (rows, given_s) = self.motion();
        let least = |values: &[f64]| {
            let rows = values.iter().copied().enumerate();
            let least = rows.min_by(|a, b| a.1.total_cmp(&b.1));
            least.map_or((1.0, 0.0), |(row, least)| (least, row as f64 * self.dt_s))
        };
        let lowered = self.share.iter().enumerate().filter(|(_, share)| !share.is_empty());
        let clamped = self.within.clamped.iter().enumerate().filter(|(_, change)| **change > 0.0);
        Fit {
            motion: RigMotion { dt_s: self.dt_s, rows: rows.lists() },
            given_s,
            slowest: least(&self.course.pace),
            lowered: lowered
                .map(|(joint, share)| {
                    let (share, at_s) = least(share);
                    LoweredJoint { joint: self.name(joint), share, at_s }
                })
                .collect(),
            clamped: clamped.map(|(joint, change)| (self.name(joint), *change)).collect(),
            lightened: if self.share.iter().all(Vec::is_empty) { vec![] } else { self.lightened() },
            smoothed: self.smoothed(),
            progress: Progress {
                widest: self.widest,
                ended: self.ended,
                pace: self.course.pace,
                share: self.share,
                room: self.within.room,
            },
        }
    }

    fn smoothed(&self) -> Vec<SmoothedJoint> {
        let of_joint = |(joint, widest): (usize, &Option<(f64, f64)>)| {
            let (width_s, change) = (*widest)?;
            Some(SmoothedJoint { joint: self.name(joint), width_s, change })
        };
        self.widest.iter().enumerate().filter_map(of_joint).collect()
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

/// Whether it is one that a slower or smoother motion has less of.
fn is_fast(excess: &Excess) -> bool {
    matches!(excess.kind, Kind::Speed | Kind::Acceleration | Kind::Effort)
}
