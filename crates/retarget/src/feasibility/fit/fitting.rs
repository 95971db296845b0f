//! A fit in progress: in each round the motion is checked, slowed down and lowered.

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

/// Time before and after an instant during which poses are drawn towards home, too, s.
pub(super) const LOWERING_S: f64 = 0.4;
/// Factor on the motion of a hot drive in each round.
const COOLING: f64 = 0.97;
/// Minimum share of speed, and of the distance from home. With less, the result is useless as a performance.
pub(super) const LEAST_SHARE: f64 = 0.02;
/// Number of samples beside an excess that are checked again after smoothing.
const BESIDE: usize = 2;

/// Result of a round.
pub(super) enum Round {
    /// No limit is exceeded.
    Within,
    /// A limit was exceeded, and the motion was slowed or lowered there.
    Nearer,
    /// The remaining motion is useless as a performance.
    Hopeless,
}

/// A fit in progress.
pub(super) struct Fitting<'a> {
    mechanism: &'a Mechanism,
    limits: &'a Limits,
    /// Pose that the motion is drawn towards: home, if its holding efforts are small enough.
    rest: &'a Rest,
    settings: FitSettings,
    dt_s: f64,
    /// Range of each joint's coordinates in a row.
    joints: Vec<Range<usize>>,
    /// Rows within their ranges, low-passed.
    rows: Rows,
    within: Within,
    course: LimitTrace,
    /// Share of each joint's distance from home at each row; empty if unchanged.
    share: Vec<Vec<f64>>,
    /// Widest low-pass of each joint: its width, s, and the change that it caused.
    widest: Vec<Option<(f64, f64)>>,
    /// Joints that a wider low-pass may not change.
    ended: Vec<bool>,
    efforts: Efforts,
    /// Rows of the motion in given time; kept while rows and shares are unchanged.
    still: Option<Rows>,
    /// Dofs that exceeded a limit of speed, acceleration or effort in any round.
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

    /// Continues from the changes of an earlier fit of the motion.
    pub(super) fn go_on_from(&mut self, before: &Progress) {
        let Progress { widest, ended, pace, share, room, .. } = before.clone();
        (self.widest, self.ended, self.share) = (widest, ended, share);
        (self.course.pace, self.within.room) = (pace, room);
        self.rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
    }

    /// Low-passes joints that are too fast, while the change is small. Returns whether no limit is exceeded at all.
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
                .map(|excess| self.limits.ties.leader_of(self.limits.dofs[excess.dof].joint))
                .filter(|joint| !self.ended[*joint])
                .collect();
            if wanted.is_empty() {
                break;
            }
            wanted.sort_unstable();
            wanted.dedup();
            // If an earlier fit has smoothed a joint, only wider low-passes are tried.
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
            self.rows.iter_mut().for_each(|row| self.limits.ties.follow(row));
            // A low-pass only reduces existing excesses, and only those of joints that it may still change,
            // therefore only their samples are checked here. The rounds check everything.
            (report, looks) = self.excesses_of_rows(Some(&looks))?;
        }
        Ok(false)
    }

    /// Applies the low-passes of an earlier fit.
    fn smooth_as_before(&mut self, given: &Rows) {
        for (joint, widest) in self.widest.iter().enumerate() {
            if let Some((width_s, _)) = widest {
                let (sigma, rows) = (width_s / self.dt_s, &mut self.rows);
                smooth::smooth(self.mechanism, joint, given, rows, sigma, f64::INFINITY);
            }
        }
        self.rows.iter_mut().for_each(|row| self.limits.ties.follow(row));
    }

    /// Checks the rows, at all samples or at some. Returns the report, and the samples near which joints that may
    /// still be smoothed are too fast or too strong.
    fn excesses_of_rows(&mut self, at: Option<&[usize]>) -> Result<(Report, Vec<usize>), FitError> {
        let leader = |joint: usize| self.limits.ties.leader_of(joint);
        let may_be_smoothed = |limits: &DofLimits| !self.ended[leader(limits.joint)];
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

    /// Performs one round: finds where the motion exceeds a limit, and slows or lowers it there.
    pub(super) fn round(&mut self) -> Result<Round, FitError> {
        let given_s = self.course.given_s();
        let mut still = self.still_rows();
        // Limits how many curves as long as the clip exist at a time, because they need much memory.
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
        let ties = &self.limits.ties;
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
        // A follower is drawn towards home by its leader.
        for tie in ties.each() {
            let own = std::mem::take(&mut share[tie.body]);
            if share[tie.leader].is_empty() {
                share[tie.leader] = own;
            } else {
                let of_leader = share[tie.leader].iter_mut().zip(own);
                of_leader.for_each(|(leader, own)| *leader = leader.min(own));
            }
        }
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

    /// Slows the motion where it was too fast, as far as the model predicts without another check.
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

    /// Draws joints towards home by shares of their distance at each row. Returns whether any was drawn.
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

    /// Increases the margin at range ends that the curve exceeds: between two rows at an end of a range, the curve
    /// overshoots. Returns whether any was increased.
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

    /// Returns the rows of the present motion, in given time.
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
        // A joint that was changed alone may violate its ties.
        rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
        rows
    }

    /// Returns the rows of the present motion in its own time, and the given time of each row, s.
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

    /// Returns the present motion as a curve, and the given time of each row, s.
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
            settings: self.settings,
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
                caps: Vec::new(),
                is_curved: Vec::new(),
                starts_slowly: Vec::new(),
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

    /// Returns the joints of the rest pose that are not at home, and their distance from it.
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

/// Returns whether a slower or smoother motion reduces this kind of excess.
fn is_fast(excess: &Excess) -> bool {
    matches!(excess.kind, Kind::Speed | Kind::Acceleration | Kind::Effort)
}
