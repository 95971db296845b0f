//! A fit that keeps the time: where a motion exceeds a limit, it becomes smaller or smoother.
//!
//! Each joint that is too fast gets the nearest curve within its limits ([`nearest`]). If an effort is too large, the
//! limits of the joints that cause it are lowered around that time ([`caps`]). If gravity alone needs too much effort,
//! the pose is drawn towards home, as in a fit that slows down. Rounds are repeated until no limit is exceeded.

mod calm;
mod caps;
mod nearest;
#[cfg(test)]
mod tests;

use std::ops::Range;

use sinew_rig::Mechanism;
use sinew_rig::mechanism::JointModel;

use super::course::lessen;
use super::error::FitError;
use super::fitting::{LEAST_SHARE, LOWERING_S, Round};
use super::joint::{distance, draw, normalize};
use super::progress::Progress;
use super::rest::Rest;
use super::result::{Fit, FitSettings, LoweredJoint};
use super::within::Within;
use crate::feasibility::curve::{Curve, Instant, Performance as _};
use crate::feasibility::efforts::Efforts;
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::Limits;
use crate::feasibility::motion::RigMotion;
use crate::feasibility::report::{Excess, Kind};
use crate::feasibility::rows::Rows;
use calm::Scan;
pub(super) use caps::Caps;
use nearest::{CurveLimits, nearest};

/// Factor that each round applies to the motion of a drive that is too hot.
const COOLING: f64 = 0.97;
/// Maximum speed at the beginning of a motion that begins at rest, rad/s or m/s. It is below the speed at which a
/// controller begins a show without a delay, also through a gear.
const AT_REST: f64 = 0.02;
/// First share of a ball joint's limits for each number of its quaternion, because the numbers' speeds add up. A
/// quaternion changes half as fast as the joint turns.
const OF_QUATERNION: f64 = 0.5 * 0.7;

/// State of a fit that keeps the time.
pub(super) struct Keeping<'a> {
    mechanism: &'a Mechanism,
    limits: &'a Limits,
    rest: &'a Rest,
    settings: FitSettings,
    dt_s: f64,
    /// Range of each joint's coordinates in a row.
    joints: Vec<Range<usize>>,
    given: Rows,
    within: Within,
    /// Share of each joint's distance from home at each row; empty without a change.
    share: Vec<Vec<f64>>,
    /// Lowered limits of each joint at each row.
    caps: Vec<Caps>,
    /// For each joint: whether it needs its own curve.
    is_curved: Vec<bool>,
    /// For each joint: whether it began at speed and must begin at rest.
    starts_slowly: Vec<bool>,
    /// Curves that were found for each joint, a list for each coordinate; `None` if they must be computed anew.
    curves: Vec<Option<Vec<Vec<f64>>>>,
    efforts: Efforts,
}

impl<'a> Keeping<'a> {
    pub(super) fn new(
        mechanism: &'a Mechanism,
        limits: &'a Limits,
        rest: &'a Rest,
        motion: &RigMotion,
        settings: FitSettings,
    ) -> Result<Self, FitError> {
        let count = mechanism.bodies.len();
        Ok(Self {
            mechanism,
            limits,
            rest,
            settings,
            dt_s: motion.dt_s,
            joints: mechanism.coordinate_ranges(),
            given: Rows::of(mechanism.coordinate_count(), &motion.rows),
            within: Within::new(mechanism, settings.room),
            share: vec![Vec::new(); count],
            caps: vec![Caps::default(); count],
            is_curved: vec![false; count],
            starts_slowly: vec![false; count],
            curves: vec![None; count],
            efforts: Efforts::asked_by(mechanism, limits).map_err(CheckError::Tree)?,
        })
    }

    /// Continues with the changes that an earlier fit of the motion has made.
    pub(super) fn go_on_from(&mut self, before: &Progress) {
        let Progress { share, room, caps, is_curved, starts_slowly, .. } = before.clone();
        (self.share, self.within.room, self.caps) = (share, room, caps);
        (self.is_curved, self.starts_slowly) = (is_curved, starts_slowly);
    }

    /// Performs one round: finds where the motion exceeds a limit, and makes it smaller or smoother there.
    pub(super) fn round(&mut self) -> Result<Round, FitError> {
        let curve = self.curve();
        let scan = Scan {
            mechanism: self.mechanism,
            limits: self.limits,
            rest: self.rest,
            efforts: &mut self.efforts,
            rate_hz: self.settings.rate_hz,
            dt_s: self.dt_s,
            rows: self.given.count,
        };
        let mut found = scan.of(&curve)?;
        let begins = self.begins_at_speed(&curve);
        if found.report.excesses.is_empty() && begins.is_empty() {
            return Ok(Round::Within);
        }
        for joint in begins {
            self.starts_slowly[joint] = true;
            self.is_curved[joint] = true;
            self.curves[joint] = None;
        }
        let ties = &self.limits.ties;
        let excesses = std::mem::take(&mut found.report.excesses);
        for excess in &excesses {
            let joint = ties.leader_of(self.limits.dofs[excess.dof].joint);
            match excess.kind {
                Kind::Heat => found.lower_all(self.mechanism, joint, COOLING),
                Kind::Range | Kind::LinkedRange => {
                    self.within.widen(self.limits.dofs[excess.dof].joint, beyond(excess));
                    // Joints that limits connect with this joint move, too.
                    self.curves.fill(None);
                }
                Kind::Speed | Kind::Acceleration | Kind::Effort | Kind::Following => {}
            }
        }
        found.follow(ties);
        for joint in 0..self.joints.len() {
            if !found.share[joint].is_empty() {
                let share = &mut self.share[joint];
                if share.is_empty() {
                    *share = vec![1.0; self.given.count];
                }
                lessen(share, 0, &found.share[joint], LOWERING_S / self.dt_s);
                // The way to the pose nearer to home must keep the limits, too.
                self.is_curved[joint] = true;
                self.curves[joint] = None;
            }
            let is_fast = found.is_fast[joint];
            if is_fast && !self.is_curved[joint] {
                self.is_curved[joint] = true;
                self.curves[joint] = None;
            } else if let Some(calm) = found.calm(joint, is_fast) {
                let now = found.speeds_of(&curve, self.limits, joint);
                self.caps[joint].calm(&now, &calm.shares, calm.slower, self.dt_s);
                self.is_curved[joint] = true;
                self.curves[joint] = None;
            }
        }
        let least = self.share.iter().flatten().copied().fold(1.0, f64::min);
        Ok(if least < LEAST_SHARE { Round::Hopeless } else { Round::Nearer })
    }

    /// Returns the joints that begin faster than permitted, and do not have a lower limit there yet.
    fn begins_at_speed(&self, curve: &Curve) -> Vec<usize> {
        let mut instant = Instant::default();
        curve.at(0.0, &mut instant);
        let dofs = self.limits.dofs.iter().zip(&instant.qd);
        let fast = dofs.filter(|(_, speed)| self.settings.from_rest && speed.abs() > AT_REST);
        let mut joints: Vec<usize> =
            fast.map(|(dof, _)| self.limits.ties.leader_of(dof.joint)).collect();
        // The base is not changed.
        let is_changed = |joint: &usize| self.mechanism.bodies[*joint].joint != JointModel::Free;
        joints.retain(|joint| !self.starts_slowly[*joint] && is_changed(joint));
        joints.dedup();
        joints
    }

    /// Returns the present motion as a curve.
    pub(super) fn curve(&mut self) -> Curve {
        let rows = self.rows();
        Curve::through(&self.joints, rows, self.dt_s)
    }

    /// Returns the rows of the present motion.
    fn rows(&mut self) -> Rows {
        let mut rows = self.given.clone();
        for (share, range) in self.share.iter().zip(&self.joints).filter(|(s, _)| !s.is_empty()) {
            for (row, share) in rows.iter_mut().zip(share) {
                draw(&mut row[range.clone()], &self.rest.q[range.clone()], *share);
            }
        }
        rows.iter_mut().for_each(|row| self.within.bring(self.limits, row));
        for joint in (0..self.joints.len()).filter(|joint| self.is_curved[*joint]) {
            let numbers = self.joints[joint].clone();
            if self.curves[joint].is_none() {
                let all = numbers.clone().enumerate();
                let curve = |(axis, k)| nearest(&rows.column(k), &self.curve_limits(joint, axis));
                self.curves[joint] = Some(all.map(curve).collect());
            }
            let Some(curves) = &self.curves[joint] else { continue };
            for (index, row) in rows.iter_mut().enumerate() {
                let of_joint = &mut row[numbers.clone()];
                for (place, curve) in of_joint.iter_mut().zip(curves) {
                    *place = curve[index];
                }
                normalize(of_joint);
            }
        }
        rows.iter_mut().for_each(|row| self.limits.ties.follow(row));
        rows
    }

    /// Returns the limits of one coordinate of a joint. Times are counted in rows.
    fn curve_limits(&self, joint: usize, axis: usize) -> CurveLimits {
        let of_joint = self.limits.dofs.iter().filter(|dof| dof.joint == joint);
        let dofs: Vec<_> = of_joint.collect();
        let is_scalar = dofs.len() == self.joints[joint].len();
        let (dof, scale) = if is_scalar { (dofs[axis], 1.0) } else { (dofs[0], OF_QUATERNION) };
        let caps = &self.caps[joint];
        let none = vec![f64::INFINITY; self.given.count];
        let own = |of_caps: &[f64], most: f64, unit: f64| -> Vec<f64> {
            let caps = if of_caps.is_empty() { &none[..] } else { of_caps };
            caps.iter().map(|cap| cap.min(most) * scale * unit).collect()
        };
        let mut speed = own(&caps.speed, dof.speed, self.dt_s);
        if self.starts_slowly[joint] {
            // The first two differences of control points determine the speed at the first row.
            let slow = 0.5 * AT_REST * scale * self.dt_s;
            speed.iter_mut().take(2).for_each(|speed| *speed = speed.min(slow));
        }
        CurveLimits {
            range: if is_scalar {
                self.within.inner(joint, dof.range)
            } else {
                [f64::NEG_INFINITY, f64::INFINITY]
            },
            speed,
            acceleration: own(&caps.acceleration, dof.acceleration, self.dt_s * self.dt_s),
        }
    }

    pub(super) fn done(mut self) -> Fit {
        let rows = self.rows();
        let count = self.given.count;
        let least = |values: &[f64]| {
            let rows = values.iter().copied().enumerate();
            let least = rows.min_by(|a, b| a.1.total_cmp(&b.1));
            least.map_or((1.0, 0.0), |(row, least)| (least, row as f64 * self.dt_s))
        };
        let name = |joint: usize| self.mechanism.bodies[joint].joint_name.clone();
        let home = self.mechanism.home();
        let lowered: Vec<LoweredJoint> = (self.share.iter().enumerate())
            .filter(|(_, share)| !share.is_empty())
            .map(|(joint, share)| {
                let (share, at_s) = least(share);
                LoweredJoint { joint: name(joint), share, at_s }
            })
            .collect();
        let clamped = self.within.clamped.iter().enumerate().filter(|(_, change)| **change > 0.0);
        let lightened = self.joints.iter().enumerate().map(|(joint, range)| {
            (joint, distance(&self.rest.q[range.clone()], &home[range.clone()]))
        });
        let lightened = lightened.filter(|(_, by)| *by > 0.0 && !lowered.is_empty());
        Fit {
            motion: RigMotion { dt_s: self.dt_s, rows: rows.lists() },
            given_s: (0..count).map(|row| row as f64 * self.dt_s).collect(),
            settings: self.settings,
            slowest: (1.0, 0.0),
            clamped: clamped.map(|(joint, change)| (name(joint), *change)).collect(),
            lightened: lightened.map(|(joint, by)| (name(joint), by)).collect(),
            lowered,
            smoothed: Vec::new(),
            progress: Progress {
                widest: vec![None; self.joints.len()],
                ended: vec![false; self.joints.len()],
                pace: vec![1.0; count],
                share: self.share,
                room: self.within.room,
                caps: self.caps,
                is_curved: self.is_curved,
                starts_slowly: self.starts_slowly,
            },
        }
    }
}

/// Returns the amount by which a value exceeds its limit.
fn beyond(excess: &Excess) -> f64 {
    (excess.value - excess.limit).abs()
}
