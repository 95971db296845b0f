//! Where a motion exceeds a limit, and by how much it must be slower or nearer to home there.

use sinew_rig::Mechanism;
use sinew_rig::mechanism::{JointModel, LANES};

use super::interpolation::interpolated;
use super::rest::Rest;
use crate::feasibility::check::Tally;
use crate::feasibility::curve::{Curve, Performance as _};
use crate::feasibility::efforts::{Block, Efforts};
use crate::feasibility::error::CheckError;
use crate::feasibility::limits::{DofLimits, Limits};
use crate::feasibility::report::Report;

/// Share of its effort that may hold a joint where it is asked for more.
const MOST_HELD: f64 = 0.9;

/// What a motion is looked at with.
pub(super) struct LimitScan<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) limits: &'a Limits,
    pub(super) rest: &'a Rest,
    pub(super) efforts: &'a mut Efforts,
    pub(super) rate_hz: f64,
    /// Of the given rows.
    pub(super) dt_s: f64,
    pub(super) rows: usize,
}

/// What was seen.
pub(super) struct ScanResult {
    pub(super) report: Report,
    /// What share of its speed the motion may have at each given row.
    pub(super) pace: Vec<f64>,
    /// Of each joint what share of its way from home at each given row; empty where it is whole.
    pub(super) share: Vec<Vec<f64>>,
}

impl LimitScan<'_> {
    /// Looks at all of a motion, whose rows are at these given times, s; `None`: at their own. Between its looks it
    /// sees nothing: they are as many as those of the check.
    pub(super) fn at(
        self,
        curve: &Curve,
        given_s: Option<&[f64]>,
    ) -> Result<ScanResult, CheckError> {
        let LimitScan { mechanism, limits, rest, efforts, rate_hz, dt_s, rows: count } = self;
        let mut pace_at = vec![1.0; count];
        let mut share = vec![Vec::new(); mechanism.bodies.len()];
        let (mut block, mut holding, mut is_beyond) =
            (Block::default(), Default::default(), [false; LANES]);
        let mut tally = Tally::new(mechanism, limits, rate_hz);
        let duration_s = curve.duration_s();
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "positive")]
        let looks = (duration_s * rate_hz).ceil() as usize;
        let mut times_s = (0..=looks).map(|look| (look as f64 / rate_hz).min(duration_s));
        while block.next(curve, &mut times_s) {
            block.find_efforts(efforts)?;
            is_beyond.fill(false);
            for (is_beyond, (time_s, instant, of_instant)) in is_beyond.iter_mut().zip(block.each())
            {
                *is_beyond = tally.take(time_s, instant, of_instant);
            }
            if !is_beyond.contains(&true) {
                continue;
            }
            block.holding(efforts, &mut holding)?;
            let beyond =
                block.each().zip(&holding).zip(is_beyond).filter(|(_, is_beyond)| *is_beyond);
            for (((time_s, instant, of_instant), holding), _) in beyond {
                let given =
                    given_s.map_or(time_s, |given_s| interpolated(given_s, time_s / dt_s)) / dt_s;
                #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "rows")]
                let rows = [given.floor(), given.ceil()].map(|row| (row as usize).min(count - 1));
                for (dof, limits_of) in limits.dofs.iter().enumerate() {
                    // Friction is the same however slow the course is.
                    let dry = efforts.dry_friction(dof, instant.qd[dof]);
                    let (effort, held) = (of_instant[dof], holding[dof] + dry);
                    let (qd, qdd) = (instant.qd[dof], instant.qdd[dof]);
                    let most = most_held(limits_of, rest.holding[dof]);
                    let is_heavy =
                        effort.abs().max(held.abs()) > limits_of.effort && held.abs() > most;
                    let pace = pace(limits_of, [qd, qdd], (!is_heavy).then_some([effort, held]));
                    for row in rows {
                        pace_at[row] = f64::min(pace_at[row], pace);
                        if is_heavy {
                            let joint = limits_of.joint;
                            lower_chain(
                                mechanism,
                                &mut share,
                                joint,
                                [row, count],
                                ratio(held, most),
                            );
                        }
                    }
                }
            }
        }
        Ok(ScanResult { report: tally.report(duration_s, looks + 1), pace: pace_at, share })
    }
}

/// The effort that may hold a dof where more is asked than it gives: with less left for motion, slower is no help.
/// `at_rest`: what holds it there.
pub(super) fn most_held(limits: &DofLimits, at_rest: f64) -> f64 {
    (MOST_HELD * limits.effort).max(0.5 * (at_rest.abs() + limits.effort))
}

/// Draws a joint towards rest at a row of so many, with the joints that it carries and that carry it.
pub(super) fn lower_chain(
    mechanism: &Mechanism,
    lower: &mut [Vec<f64>],
    joint: usize,
    [row, rows]: [usize; 2],
    share: f64,
) {
    for (other, (link, lower)) in mechanism.bodies.iter().zip(lower).enumerate() {
        let in_chain = mechanism.supports(joint, other) || mechanism.supports(other, joint);
        // A base is no joint that could be drawn anywhere.
        if in_chain && !matches!(link.joint, JointModel::Free | JointModel::Fixed) {
            if lower.is_empty() {
                *lower = vec![1.0; rows];
            }
            lower[row] = lower[row].min(share);
        }
    }
}

/// The share of its speed that a motion may have for one dof: of its speed and acceleration, and, if slower helps, of
/// its effort and the part of that which is there however slow it goes.
pub(super) fn pace(limits: &DofLimits, [qd, qdd]: [f64; 2], efforts: Option<[f64; 2]>) -> f64 {
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
