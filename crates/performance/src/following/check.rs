//! Plays a show on simulated servos to predict its following errors.

use sinew_firmware::supervisor::detect::FollowingSettings;
use sinew_firmware::supervisor::{FaultSet, State};
use sinew_retarget::feasibility::Report;
use sinew_rig::{Description, Mechanism};
use sinew_servo_sim::device::MEMORY_LEN;
use sinew_show::{Position, Show};

use super::lag::{ServoLag, servo_lags};
use super::prediction::{Detectors, LargestError, Prediction};
use crate::play::{Director, Memory, Options, RigParts, SimulatedRig, closes_loop};

/// Stack size of the thread that builds a controller with all its capacities.
const STACK_BYTES: usize = 64 << 20;
/// Share of the supervisor's limit that the error of a fitted show may reach: real servos differ from their models.
const FITTED_SHARE: f32 = 0.8;

/// Permitted following errors of a show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Allowance {
    /// The supervisor's own limits: an error of any size for less than its time, and up to its limit for any time.
    Supervisor,
    /// The room of a fit: at most 0.8 of the supervisor's limit, at all times.
    Fit,
}

/// Predicts the following errors of shows of a rig.
pub struct FollowingCheck {
    rig: Description,
    mechanism: Mechanism,
    parts: RigParts,
    lags: Vec<ServoLag>,
    limit: FollowingSettings,
}

impl FollowingCheck {
    /// Prepares a rig, whose shows have this CRC. Returns `None` if no servo closes its own loop and reports its
    /// position. Also returns `None` if the rig cannot play and no drive is given: `sinew play` states the reason.
    ///
    /// # Errors
    /// The rig cannot play with the given drive, or a drive does not accept a pose of its range.
    pub fn new(
        rig: &Description,
        mechanism: &Mechanism,
        options: Options,
        rig_crc: u32,
    ) -> anyhow::Result<Option<Self>> {
        if options.drive.is_none() && rig.servos.iter().all(|servo| closes_loop(&servo.model)) {
            return Ok(None);
        }
        let mut parts = match RigParts::new(rig, mechanism, options) {
            Ok(parts) => parts,
            Err(_) if options.drive.is_none() => return Ok(None),
            Err(why) => return Err(why.into()),
        };
        let lags = servo_lags(&parts)?;
        let limit = parts.without_following_faults();
        parts.take_shows_of(rig_crc);
        let (rig, mechanism) = (rig.clone(), mechanism.clone());
        Ok((!lags.is_empty()).then_some(Self { rig, mechanism, parts, lags, limit }))
    }

    /// Predicts the following errors of a show. `report`: the check of the show.
    ///
    /// # Errors
    /// The rig or the show cannot be simulated.
    pub fn of(
        &self,
        show: &[u8],
        report: &Report,
        allowance: Allowance,
    ) -> anyhow::Result<Prediction> {
        let limit = match allowance {
            Allowance::Supervisor => self.limit,
            Allowance::Fit => {
                FollowingSettings { most_rad: FITTED_SHARE * self.limit.most_rad, time_s: 0.0 }
            }
        };
        if let Some(largest) =
            self.bound(report).filter(|bound| bound.error < limit.most_rad.into())
        {
            let (excesses, stopped) = (Vec::new(), None);
            return Ok(Prediction { limit: self.limit, largest, excesses, stopped });
        }
        std::thread::scope(|scope| {
            let builder = std::thread::Builder::new().stack_size(STACK_BYTES);
            let done = builder.spawn_scoped(scope, || self.played(show, limit))?.join();
            done.unwrap_or_else(|panic| std::panic::resume_unwind(panic))
        })
    }

    /// Returns the largest bound of all dofs; `None` if a dof has no bound.
    pub(super) fn bound(&self, report: &Report) -> Option<LargestError> {
        let bounds = self.lags.iter().map(|lag| {
            let error = lag.bound(&report.peaks[lag.dof])?;
            Some(LargestError { dof: lag.dof, error, at_s: None })
        });
        let bounds: Vec<LargestError> = bounds.collect::<Option<_>>()?;
        bounds.into_iter().max_by(|a, b| a.error.total_cmp(&b.error))
    }

    /// Plays a show once, without faults by following errors.
    pub(super) fn played(
        &self,
        bytes: &[u8],
        limit: FollowingSettings,
    ) -> anyhow::Result<Prediction> {
        let Self { rig, mechanism, parts, .. } = self;
        let mut memories: Vec<Memory> = vec![[0; MEMORY_LEN]; parts.servos.len()];
        let plant = parts.plant(rig, mechanism)?;
        let mut sim = SimulatedRig::new(parts, Some(bytes), &mut memories, plant)?;
        let show = Show::open(bytes)?;
        let (rate_hz, duration_s) = (f64::from(show.rate().hz()), f64::from(show.duration_s()));
        let dt_s = 1e-6 * f64::from(parts.tick_us());
        #[expect(clippy::cast_possible_truncation, reason = "a board computes in f32")]
        let mut detectors =
            Detectors::new(limit, dt_s as f32, self.lags.iter().map(|lag| lag.dof))?;
        let (mut director, mut ran_s, mut lost) = (Director::default(), 0.0, None);
        let is_whole = loop {
            let ended = director.tick(&mut sim, false);
            let report = sim.report();
            let runs = sim.runs() && report.state == State::Playing;
            if runs {
                let at = report.show.map_or(0, Position::sample);
                lost = detectors.note(f64::from(at) / rate_hz, |dof| report.dofs[dof].error);
                if lost.is_some() {
                    break false;
                }
                ran_s += dt_s;
            }
            // A loop does not end by itself.
            if show.is_loop() && ran_s >= duration_s {
                break true;
            }
            if ended.is_some() || (ran_s > 0.0 && !runs) {
                break report.state == State::Holding && !has_faults(&director);
            }
        };
        let faults = director.raised().minus(FaultSet::WARNINGS);
        let stopped = (!is_whole).then(|| {
            let named: Vec<String> = faults.iter().map(|fault| sim.named(fault)).collect();
            match lost {
                Some(dof) => format!("the position of `{}` is not finite", parts.names[dof]),
                None if named.is_empty() => "the rig cannot be armed".to_owned(),
                None => named.join(", "),
            }
        });
        let (largest, excesses) = detectors.result();
        Ok(Prediction { limit: self.limit, largest, excesses, stopped })
    }
}

fn has_faults(director: &Director) -> bool {
    !director.raised().minus(FaultSet::WARNINGS).is_empty()
}
