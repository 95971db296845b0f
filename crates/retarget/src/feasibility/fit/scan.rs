//! Finds where a motion exceeds a limit, and how much slower or nearer to home it must be there.

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

/// Maximum share of an effort limit for holding, if the motion needs more than the limit.
const MOST_HELD: f64 = 0.9;

/// Inputs of a scan.
pub(super) struct LimitScan<'a> {
    pub(super) mechanism: &'a Mechanism,
    pub(super) limits: &'a Limits,
    pub(super) rest: &'a Rest,
    pub(super) efforts: &'a mut Efforts,
    pub(super) rate_hz: f64,
    /// Time from row to row of the given motion, s.
    pub(super) dt_s: f64,
    pub(super) rows: usize,
}

/// Result of a scan.
pub(super) struct ScanResult {
    pub(super) report: Report,
    /// Permitted share of the speed at each given row.
    pub(super) pace: Vec<f64>,
    /// Permitted share of each joint's distance from home at each given row; empty if unchanged.
    pub(super) share: Vec<Vec<f64>>,
}

impl LimitScan<'_> {
    /// Scans a whole motion, whose rows are at these given times, s; with `None`, at their own times. It samples as
    /// often as the check, and sees nothing between samples.
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
                    // Friction does not depend on the pace.
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

/// Returns the maximum holding effort of a dof whose limit is exceeded: above it, too little remains for motion,
/// and slowing does not help. `at_rest` is its holding effort in the rest pose.
pub(super) fn most_held(limits: &DofLimits, at_rest: f64) -> f64 {
    (MOST_HELD * limits.effort).max(0.5 * (at_rest.abs() + limits.effort))
}

/// Draws a joint towards rest at row `row` of `rows`, together with all joints that it moves or that move it.
pub(super) fn lower_chain(
    mechanism: &Mechanism,
    lower: &mut [Vec<f64>],
    joint: usize,
    [row, rows]: [usize; 2],
    share: f64,
) {
    for (other, (link, lower)) in mechanism.bodies.iter().zip(lower).enumerate() {
        let in_chain = mechanism.supports(joint, other) || mechanism.supports(other, joint);
        // A base is not drawn anywhere.
        if in_chain && !matches!(link.joint, JointModel::Free | JointModel::Fixed) {
            if lower.is_empty() {
                *lower = vec![1.0; rows];
            }
            lower[row] = lower[row].min(share);
        }
    }
}

/// Returns the share of its speed that the motion may have for one dof, from speed and acceleration and, if slowing
/// helps, from its effort and the part of the effort that does not depend on the pace.
pub(super) fn pace(limits: &DofLimits, [qd, qdd]: [f64; 2], efforts: Option<[f64; 2]>) -> f64 {
    let of_motion = ratio(qd, limits.speed).min(libm::sqrt(ratio(qdd, limits.acceleration)));
    let Some([effort, held]) = efforts.filter(|[effort, _]| effort.abs() > limits.effort) else {
        return of_motion;
    };
    // Remaining effort for motion, beside gravity and friction.
    let moving = effort - held;
    let left = (limits.effort - held * moving.signum()).max(0.0);
    of_motion.min(libm::sqrt(ratio(moving, left)))
}

/// Returns the share of a value that a limit permits, at most 1.
fn ratio(value: f64, limit: f64) -> f64 {
    (limit / value.abs()).min(1.0)
}
