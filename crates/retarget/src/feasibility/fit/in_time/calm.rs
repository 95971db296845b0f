//! Finds where a motion exceeds a limit, which joints cause this, and the share of their acceleration that is
//! permitted.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::{LANES, Ties};

use super::super::rest::Rest;
use super::super::scan::{lower_chain, most_held};
use super::caps::RowSpeeds;
use crate::feasibility::check::Tally;
use crate::feasibility::curve::{Curve, Instant, Performance as _};
use crate::feasibility::efforts::{Block, Efforts};
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::{DofLimits, Limits};
use crate::feasibility::report::Report;

/// Smallest share of an effort at which a joint counts as one of its causes.
const CAUSE: f64 = 0.05;
/// Smallest share that is permitted in one round. A smaller share could reduce the motion too much.
const LEAST: f64 = 0.4;

/// Inputs of a scan for exceeded limits.
pub(super) struct Scan<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) limits: &'a Limits,
    pub(super) rest: &'a Rest,
    pub(super) efforts: &'a mut Efforts,
    pub(super) rate_hz: f64,
    pub(super) dt_s: f64,
    pub(super) rows: usize,
}

/// Reduction of a joint's acceleration and speed at each row.
#[derive(Debug, Clone, Default)]
pub(super) struct Calm {
    /// Permitted share of the present acceleration; empty if the joint need not change.
    pub(super) shares: Vec<f64>,
    /// Whether the joint's speed must become smaller, too.
    pub(super) slower: bool,
}

impl Calm {
    fn lower(&mut self, rows: [usize; 2], count: usize, share: f64) {
        if self.shares.is_empty() {
            self.shares = vec![1.0; count];
        }
        for row in rows {
            self.shares[row] = self.shares[row].min(share.max(LEAST));
        }
    }
}

/// Results of a scan.
pub(super) struct Found {
    pub(super) report: Report,
    /// For each joint: whether it exceeds its own limit of speed or acceleration.
    pub(super) is_fast: Vec<bool>,
    /// Permitted share of each joint's distance from home at each row; empty without a change.
    pub(super) share: Vec<Vec<f64>>,
    /// Reductions of each joint: because of efforts, and because of its own speed and acceleration.
    by_effort: Vec<Calm>,
    by_speed: Vec<Calm>,
    rows: usize,
}

impl Scan<'_> {
    /// Scans a whole motion, at the instants at which the check looks at it.
    pub(super) fn of(self, curve: &Curve) -> Result<Found, CheckError> {
        let Scan { mechanism, limits, rest, efforts, rate_hz, dt_s, rows: count } = self;
        let bodies = mechanism.bodies.len();
        let mut tally = Tally::new(mechanism, limits, rate_hz);
        let mut found = Found {
            report: Report { duration_s: 0.0, peaks: vec![], excesses: vec![] },
            is_fast: vec![false; bodies],
            share: vec![Vec::new(); bodies],
            by_effort: vec![Calm::default(); bodies],
            by_speed: vec![Calm::default(); bodies],
            rows: count,
        };
        let duration_s = curve.duration_s();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let looks = (duration_s * rate_hz).ceil() as usize;
        let mut times_s = (0..=looks).map(|look| (look as f64 / rate_hz).min(duration_s));
        let (mut block, mut is_beyond) = (Block::default(), [false; LANES]);
        while block.next(curve, &mut times_s) {
            block.find_efforts(efforts)?;
            is_beyond.fill(false);
            for (is_beyond, (time_s, instant, of_instant)) in is_beyond.iter_mut().zip(block.each())
            {
                *is_beyond = tally.take(time_s, instant, of_instant);
            }
            for ((time_s, instant, of_instant), _) in
                block.each().zip(is_beyond).filter(|(_, is_beyond)| *is_beyond)
            {
                let place = time_s / dt_s;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows")]
                let rows = [place.floor(), place.ceil()].map(|row| (row as usize).min(count - 1));
                found.note_speeds(limits, instant, rows);
                let is_strong = |(limits, effort): (&DofLimits, &f64)| effort.abs() > limits.effort;
                if limits.dofs.iter().zip(of_instant).any(is_strong) {
                    let causes = Causes::of(mechanism, efforts, time_s, instant)?;
                    found.note_efforts((mechanism, limits, rest), &causes, of_instant, rows);
                }
            }
        }
        found.report = tally.report(duration_s, looks + 1);
        Ok(found)
    }
}

impl Found {
    /// Stores which joints exceed their speed or acceleration, and the permitted shares.
    fn note_speeds(&mut self, limits: &Limits, instant: &Instant, rows: [usize; 2]) {
        for (dof, limits_of) in limits.dofs.iter().enumerate() {
            let joint = limits.ties.leader_of(limits_of.joint);
            let [speed, acceleration] = [instant.qd[dof].abs(), instant.qdd[dof].abs()];
            let is_slow = speed <= limits_of.speed;
            if is_slow && acceleration <= limits_of.acceleration {
                continue;
            }
            self.is_fast[joint] = true;
            let of_speed = (limits_of.speed / speed).min(1.0);
            let share = (limits_of.acceleration / acceleration).min(of_speed * of_speed);
            let calm = &mut self.by_speed[joint];
            calm.slower |= !is_slow;
            calm.lower(rows, self.rows, share);
        }
    }

    /// Stores which joints cause an effort beyond its limit, and which joints must come nearer to home, because gravity
    /// alone exceeds the limit.
    fn note_efforts(
        &mut self,
        (mechanism, limits, rest): (&Mechanism, &Limits, &Rest),
        causes: &Causes,
        of_instant: &[f64],
        rows: [usize; 2],
    ) {
        for (dof, (limits_of, effort)) in limits.dofs.iter().zip(of_instant).enumerate() {
            let beyond = effort.abs() - limits_of.effort;
            if beyond <= 0.0 {
                continue;
            }
            let held = causes.held[dof];
            let most = most_held(limits_of, rest.holding[dof]);
            if held.abs() > most {
                for row in rows {
                    let share = (most / held.abs()).min(1.0);
                    lower_chain(
                        mechanism,
                        &mut self.share,
                        limits_of.joint,
                        [row, self.rows],
                        share,
                    );
                }
                continue;
            }
            let sign = effort.signum();
            let of_joint = |by: &[f64]| (sign * by[dof]).max(0.0);
            let by_speed = (sign * (effort - held)
                - causes.by_joint.iter().flatten().map(|by| sign * by[dof]).sum::<f64>())
            .max(0.0);
            let pushing: f64 =
                by_speed + causes.by_joint.iter().flatten().map(|by| of_joint(by)).sum::<f64>();
            let share = 1.0 - beyond / pushing.max(1e-12);
            for (joint, by) in causes.by_joint.iter().enumerate() {
                let Some(by) = by else { continue };
                let is_cause = of_joint(by) > CAUSE * pushing;
                let in_chain = mechanism.supports(joint, limits_of.joint)
                    || mechanism.supports(limits_of.joint, joint);
                let slower = by_speed > CAUSE * pushing && in_chain;
                if is_cause || slower {
                    let calm = &mut self.by_effort[limits.ties.leader_of(joint)];
                    calm.slower |= slower;
                    calm.lower(rows, self.rows, share);
                }
            }
        }
    }

    /// Reduces the distance from home, at all rows, of a joint, of the joints that carry it, and of the joints that it
    /// carries.
    pub(super) fn lower_all(&mut self, mechanism: &Mechanism, joint: usize, share: f64) {
        for row in 0..self.rows {
            lower_chain(mechanism, &mut self.share, joint, [row, self.rows], share);
        }
    }

    /// Applies the shares of followers to their leaders.
    pub(super) fn follow(&mut self, ties: &Ties) {
        for tie in ties.each() {
            let own = std::mem::take(&mut self.share[tie.body]);
            if self.share[tie.leader].is_empty() {
                self.share[tie.leader] = own;
            } else {
                let of_leader = self.share[tie.leader].iter_mut().zip(own);
                of_leader.for_each(|(leader, own)| *leader = leader.min(own));
            }
        }
    }

    /// Returns the reduction of a joint; `None` if the joint need not change. `is_fast`: whether the reduction because
    /// of its own speed and acceleration applies, too.
    pub(super) fn calm(&self, joint: usize, is_fast: bool) -> Option<Calm> {
        let mut calm = self.by_effort[joint].clone();
        if is_fast {
            let own = &self.by_speed[joint];
            calm.slower |= own.slower;
            for (row, share) in own.shares.iter().enumerate().filter(|(_, share)| **share < 1.0) {
                calm.lower([row, row], self.rows, *share);
            }
        }
        (!calm.shares.is_empty()).then_some(calm)
    }

    /// Returns the speeds and accelerations of a joint at all rows.
    pub(super) fn speeds_of(&self, curve: &Curve, limits: &Limits, joint: usize) -> RowSpeeds {
        let dofs: Vec<usize> =
            (0..limits.dofs.len()).filter(|dof| limits.dofs[*dof].joint == joint).collect();
        let mut instant = Instant::default();
        let mut speeds = RowSpeeds { speed: Vec::new(), acceleration: Vec::new() };
        for row in 0..self.rows {
            curve.at(row as f64 * curve.dt_s(), &mut instant);
            let most = |of: &[f64]| dofs.iter().map(|dof| of[*dof].abs()).fold(0.0, f64::max);
            speeds.speed.push(most(&instant.qd));
            speeds.acceleration.push(most(&instant.qdd));
        }
        speeds
    }
}

/// Parts of the efforts at an instant, by their causes.
struct Causes {
    /// Efforts that hold the pose, including dry friction.
    held: Vec<f64>,
    /// For each joint: the efforts on all dofs that its acceleration causes; `None` if it does not accelerate.
    by_joint: Vec<Option<Vec<f64>>>,
}

impl Causes {
    fn of(
        mechanism: &Mechanism,
        efforts: &mut Efforts,
        time_s: f64,
        instant: &Instant,
    ) -> Result<Self, CheckError> {
        let still = vec![0.0; instant.qd.len()];
        let mut of = |qdd: &[f64]| {
            let mut out = Vec::new();
            efforts
                .without_friction([&instant.q, &still, qdd], &mut out)
                .map_err(|source| CheckError::Instant { time_s, source })?;
            Ok::<_, CheckError>(out)
        };
        let mut held = of(&still)?;
        let mut by_joint = Vec::with_capacity(mechanism.bodies.len());
        let mut first = 0;
        for link in &mechanism.bodies {
            let dofs = first..first + link.joint.kind().dof_count();
            first = dofs.end;
            if instant.qdd[dofs.clone()].iter().all(|acceleration| *acceleration == 0.0) {
                by_joint.push(None);
                continue;
            }
            let mut alone = still.clone();
            alone[dofs.clone()].copy_from_slice(&instant.qdd[dofs]);
            let mut by = of(&alone)?;
            by.iter_mut().zip(&held).for_each(|(by, held)| *by -= held);
            by_joint.push(Some(by));
        }
        for (dof, (held, speed)) in held.iter_mut().zip(&instant.qd).enumerate() {
            *held += efforts.dry_friction(dof, *speed);
        }
        Ok(Self { held, by_joint })
    }
}
