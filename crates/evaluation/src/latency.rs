//! The maximum latency that methods tolerate, by control rate.

use rayon::prelude::*;
use sinew_core::tracker::MethodName;

use super::capacity::MAX_LATENCY_STEPS;
use super::controller::narrow;
use super::error::SetupError;
use super::motion::EvaluatedMotion;
use super::setup::Setup;
use super::trial::{Lost, TRACKS_BELOW_DEG, run_trial};

/// The protocol of a latency evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyProtocol {
    /// Setup that all runs share. Method, latency and prediction vary.
    pub setup: Setup,
    /// Methods to compare.
    pub methods: Vec<MethodName>,
    /// Duration of the part of every motion that is used, from its beginning, in seconds.
    pub seconds: f64,
}

/// Maximum latencies of all methods.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyLimits {
    /// Control rates, Hz.
    pub rates_hz: Vec<f64>,
    /// Two rows per method: without prediction, and with it.
    pub rows: Vec<LatencyRow>,
}

/// Maximum latencies of a method.
#[derive(Debug, Clone, PartialEq)]
pub struct LatencyRow {
    /// Method of measuring the state error.
    pub method: MethodName,
    /// Whether the controller predicts the state at which its command will act.
    pub looks_ahead: bool,
    /// Maximum latency at each rate, in steps; `None` if the method fails even without latency.
    pub largest_steps: Vec<Option<usize>>,
}

impl LatencyProtocol {
    fn setups(&self) -> Vec<Setup> {
        let of_method = |method: &MethodName| {
            let mut setup = self.setup.clone();
            setup.controller = setup.controller.with_method(*method);
            setup
        };
        self.methods.iter().map(of_method).collect()
    }

    /// Checks the setups of all methods.
    ///
    /// # Errors
    /// The first [`SetupError`].
    pub fn check(&self) -> Result<(), SetupError> {
        self.setups().iter().try_for_each(Setup::check)
    }

    /// Counts the cells of the table, for a progress bar.
    pub fn count_cells(&self, rates: usize) -> usize {
        2 * self.methods.len() * rates
    }

    /// Finds the limits of all methods with the motions of each rate, Hz. The runs are parallel; the result does
    /// not depend on the number of threads. `progress` receives the number of completed cells from time to time.
    ///
    /// # Errors
    /// [`Lost`] if a run fails for another reason than a lost figure: a motion that is too short, an invalid setting.
    pub fn run<M: EvaluatedMotion>(
        &self,
        motions: &[(f64, Vec<M>)],
        progress: impl Fn(usize) + Sync,
    ) -> Result<LatencyLimits, Lost> {
        let setups = self.setups();
        let mut cells = Vec::new();
        for setup in &setups {
            for look_ahead in [false, true] {
                cells.extend(motions.iter().map(|(_, motions)| (setup, look_ahead, motions)));
            }
        }
        let largest: Vec<_> = cells
            .par_iter()
            .map(|(setup, look_ahead, motions)| {
                let steps = find_largest_latency(motions, setup, *look_ahead, Some(self.seconds));
                progress(1);
                steps
            })
            .collect();
        let largest = largest.into_iter().collect::<Result<Vec<Option<usize>>, _>>()?;
        let rates_hz: Vec<f64> = motions.iter().map(|(rate_hz, _)| *rate_hz).collect();
        let mut largest = largest.into_iter();
        let mut rows = Vec::with_capacity(2 * self.methods.len());
        for method in &self.methods {
            for looks_ahead in [false, true] {
                let largest_steps = largest.by_ref().take(rates_hz.len()).collect();
                rows.push(LatencyRow { method: *method, looks_ahead, largest_steps });
            }
        }
        Ok(LatencyLimits { rates_hz, rows })
    }
}

/// Finds the largest latency in steps at which a figure tracks, and also tracks at every smaller latency; `None`
/// if it does not track even without latency. The controller knows the latency; `look_ahead` enables its
/// prediction.
///
/// # Errors
/// [`Lost`] if a run fails for another reason than a lost figure: a clip that is too short, an invalid setting.
pub fn find_largest_latency(
    motions: &[impl EvaluatedMotion],
    setup: &Setup,
    look_ahead: bool,
    seconds: Option<f64>,
) -> Result<Option<usize>, Lost> {
    let mut setup = setup.clone();
    if let Some(motion) = motions.first() {
        setup.controller = setup.controller.clone().effective(narrow(motion.dt_s()));
    }
    setup.controller.observer.predict = look_ahead;
    let mut largest = None;
    for latency_steps in 0..=MAX_LATENCY_STEPS {
        setup.disturbance.latency_steps = latency_steps;
        match run_trial(motions, &setup, seconds) {
            Ok(errors) if errors.all.angular_mean_deg() < TRACKS_BELOW_DEG => {
                largest = Some(latency_steps);
            }
            Ok(_) => break,
            Err(lost) if lost.kind.is_loss() => break,
            Err(other) => return Err(other),
        }
    }
    Ok(largest)
}
