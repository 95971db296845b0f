//! Results of a prediction, collected tick by tick.

use sinew_firmware::SettingError;
use sinew_firmware::supervisor::detect::{Following, FollowingSettings};
use sinew_retarget::feasibility::{Excess, Kind};

/// The largest error of all dofs whose servos close their own loop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LargestError {
    /// Index of the dof.
    pub dof: usize,
    /// The error, rad or m.
    pub error: f64,
    /// Its time in the show, s; `None` for a bound, which holds at all times.
    pub at_s: Option<f64>,
}

/// The predicted following errors of a show.
#[derive(Debug, Clone, PartialEq)]
pub struct Prediction {
    /// Limits of the supervisor.
    pub limit: FollowingSettings,
    /// The largest error.
    pub largest: LargestError,
    /// Periods in which the supervisor would end the show, or would be near to it.
    pub excesses: Vec<Excess>,
    /// The reason for which the simulated rig did not play to the end; `None` if it did.
    pub stopped: Option<String>,
}

/// The detectors of a play.
pub(super) struct Detectors {
    dofs: Vec<Detector>,
    limit: FollowingSettings,
}

/// The supervisor's detector of a dof, which continues after it has found a fault.
struct Detector {
    dof: usize,
    following: Following,
    /// The present period beyond the limit.
    now: Option<Excess>,
    found: Vec<Excess>,
    largest: f64,
    largest_s: f64,
}

impl Detectors {
    /// Creates detectors with these limits for some dofs.
    pub(super) fn new(
        limit: FollowingSettings,
        dt_s: f32,
        dofs: impl Iterator<Item = usize>,
    ) -> Result<Self, SettingError> {
        let following = Following::new(limit, dt_s)?;
        let detector = |dof| Detector {
            dof,
            following,
            now: None,
            found: Vec::new(),
            largest: 0.0,
            largest_s: 0.0,
        };
        Ok(Self { dofs: dofs.map(detector).collect(), limit })
    }

    /// Adds a tick at a time of the show, s. `error` returns the error of a dof. Returns the first dof whose error is
    /// not finite, so that nothing is known about it; `None` if there is no such dof.
    pub(super) fn note(&mut self, time_s: f64, error: impl Fn(usize) -> f32) -> Option<usize> {
        let lost = self.dofs.iter().map(|own| own.dof).find(|dof| !error(*dof).is_finite());
        if lost.is_some() {
            return lost;
        }
        for own in &mut self.dofs {
            let error_rad = error(own.dof);
            let is_fault = own.following.step(error_rad).is_some();
            let error = f64::from(error_rad.abs());
            if error > own.largest {
                (own.largest, own.largest_s) = (error, time_s);
            }
            if error_rad.abs() <= self.limit.most_rad {
                own.now = None;
                continue;
            }
            let now = own.now.get_or_insert(Excess {
                dof: own.dof,
                kind: Kind::Following,
                from_s: time_s,
                to_s: time_s,
                worst_s: time_s,
                value: 0.0,
                limit: self.limit.most_rad.into(),
            });
            now.to_s = time_s;
            if error > now.value {
                (now.value, now.worst_s) = (error, time_s);
            }
            if is_fault {
                // Until the period ends, it replaces its earlier form.
                own.found.retain(|found| found.from_s.total_cmp(&now.from_s).is_ne());
                own.found.push(now.clone());
            }
        }
        None
    }

    /// Returns the largest error of all dofs, and all periods in which the supervisor would act.
    pub(super) fn result(self) -> (LargestError, Vec<Excess>) {
        let worst = self.dofs.iter().max_by(|a, b| a.largest.total_cmp(&b.largest));
        let largest = worst.map_or(LargestError { dof: 0, error: 0.0, at_s: None }, |own| {
            LargestError { dof: own.dof, error: own.largest, at_s: Some(own.largest_s) }
        });
        (largest, self.dofs.into_iter().flat_map(|own| own.found).collect())
    }
}
