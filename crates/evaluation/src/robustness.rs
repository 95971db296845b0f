//! Methods on rigs with random errors: unknown masses, quantized sensors, late drives.

use sinew_core::tracker::MethodName;

use super::error::SetupError;
use super::metrics::Errors;
use super::motion::{EvaluatedMotion, count_steps};
use super::setup::Setup;
use super::trial::{Lost, Trial, run_trial};

/// The protocol of a robustness evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct RobustnessProtocol {
    /// Setup that all runs share. The method and the rig vary.
    pub setup: Setup,
    /// Methods to compare.
    pub methods: Vec<MethodName>,
    /// Rotation weights of the projection, in metres. `recommended` is additionally tracked with each of them.
    pub projection_weights: Vec<f32>,
    /// Number of rigs. Their seeds start at 1.
    pub rigs: u64,
    /// Duration of the part of every motion that is used, from its beginning, in seconds; `None` for whole
    /// motions.
    pub seconds: Option<f64>,
}

/// A method, or the recommended method with another weight of the projection.
#[derive(Debug, Clone, PartialEq)]
pub struct Variant {
    /// Name of the variant, for tables.
    pub name: String,
    /// Setup for the first rig.
    setup: Setup,
}

/// The result of a robustness evaluation.
#[derive(Debug, Clone, PartialEq)]
pub struct Robustness {
    /// Compared methods, which are the first variants.
    pub methods: Vec<MethodName>,
    /// Variants: the methods, then `recommended` with each weight.
    pub variants: Vec<Variant>,
    /// Trials by rig, and for each rig by variant.
    pub trials: Vec<Vec<Trial>>,
}

impl Variant {
    fn setup_of_rig(&self, seed: u64) -> Setup {
        let mut setup = self.setup.clone();
        setup.disturbance.seed = seed;
        setup
    }

    /// Returns whether the targets are poses of the rig itself, optimized for angle and distance together.
    pub fn projects(&self) -> bool {
        use MethodName::{ManifoldProjection, Recommended};
        matches!(self.setup.controller.method, ManifoldProjection | Recommended)
    }
}

impl RobustnessProtocol {
    fn variants(&self) -> Vec<Variant> {
        let of_method = |method: &MethodName| Variant {
            name: method.to_string(),
            setup: as_built(&self.setup, *method, 1),
        };
        let of_weight = |rotation_m: &f32| {
            let mut setup = as_built(&self.setup, MethodName::Recommended, 1);
            setup.controller.projection.rotation_m = *rotation_m;
            Variant { name: format!("recommended, {rotation_m} m"), setup }
        };
        let weights = self.projection_weights.iter().map(of_weight);
        self.methods.iter().map(of_method).chain(weights).collect()
    }

    /// Checks the setups of all variants.
    ///
    /// # Errors
    /// The first [`SetupError`].
    pub fn check(&self) -> Result<(), SetupError> {
        self.variants().iter().try_for_each(|variant| variant.setup.check())
    }

    /// Counts the steps of one trial.
    pub fn count_trial_steps(&self, motions: &[impl EvaluatedMotion]) -> usize {
        motions.iter().map(|motion| count_steps(motion, self.seconds)).sum()
    }

    /// Counts the steps of all trials, for a progress bar.
    pub fn count_all_steps(&self, motions: &[impl EvaluatedMotion]) -> usize {
        #[expect(clippy::cast_possible_truncation, reason = "as many as are kept in memory")]
        let rigs = self.rigs as usize;
        let variants = self.methods.len() + self.projection_weights.len();
        self.count_trial_steps(motions) * variants * rigs
    }

    /// Tracks all motions with every variant on every rig, in parallel; the result does not depend on the number
    /// of threads. `progress` receives the number of completed steps from time to time.
    ///
    /// # Errors
    /// [`Lost`] if a run fails for another reason than a lost figure: a motion that is too short, an invalid setting.
    pub fn run(
        &self,
        motions: &[impl EvaluatedMotion],
        progress: impl Fn(usize),
    ) -> Result<Robustness, Lost> {
        let variants = self.variants();
        let steps = self.count_trial_steps(motions);
        let of_rig = |seed: u64| -> Vec<Trial> {
            let of_variant = |variant: &Variant| {
                let trial = run_trial(motions, &variant.setup_of_rig(seed), self.seconds);
                progress(steps);
                trial
            };
            variants.iter().map(of_variant).collect()
        };
        let trials: Vec<Vec<Trial>> = (1..=self.rigs).map(of_rig).collect();
        for trial in trials.iter().flatten() {
            if let Err(lost) = trial
                && !lost.kind.is_loss()
            {
                return Err(lost.clone());
            }
        }
        Ok(Robustness { methods: self.methods.clone(), variants, trials })
    }
}

impl Robustness {
    /// Returns the median over the rigs of an error of a variant.
    pub fn median(&self, variant: usize, error: MeanError) -> f64 {
        let errors = self.trials.iter().map(|trials| error.of_trial(&trials[variant]));
        median(errors.collect()).unwrap_or(f64::NAN)
    }
}

/// A kind of error of a trial, as a mean over all bodies and frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MeanError {
    /// Angular error in degrees.
    Angular,
    /// Linear error in centimetres.
    Linear,
    /// Importance-weighted error in centimetres.
    Weighted,
}

impl MeanError {
    /// All kinds of error, in the order of tables.
    pub const ALL: [Self; 3] = [Self::Angular, Self::Linear, Self::Weighted];

    /// Returns this error from a trial's errors.
    pub fn of(self, errors: &Errors) -> f64 {
        match self {
            Self::Angular => errors.all.angular_mean_deg(),
            Self::Linear => errors.all.linear_mean_cm(),
            Self::Weighted => errors.weighted.mean_cm(),
        }
    }

    /// Returns this error of a trial; infinity for a lost rig, which makes it worse than any other.
    pub fn of_trial(self, trial: &Trial) -> f64 {
        trial.as_ref().map_or(f64::INFINITY, |errors| self.of(errors))
    }
}

/// Returns the setup of a rig with typical errors: masses wrong by up to 15 %, joint sensors of 12 bits, one step
/// of latency. `seed` distinguishes the rigs.
#[must_use]
pub fn as_built(setup: &Setup, method: MethodName, seed: u64) -> Setup {
    let mut setup = setup.clone();
    setup.controller = setup.controller.with_method(method);
    setup.disturbance.masses = 0.15;
    setup.disturbance.sensor_bits = 12;
    setup.disturbance.latency_steps = 1;
    setup.disturbance.seed = seed;
    setup
}

/// Returns the middle value, or the mean of the two middle values; `None` for an empty list.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let upper = *values.get(values.len() / 2)?;
    let lower = values[(values.len() - 1) / 2];
    Some(f64::midpoint(lower, upper))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(vec![]), None);
        assert_eq!(median(vec![3.0, 1.0, 2.0]), Some(2.0));
        assert_eq!(median(vec![4.0, 1.0, 2.0, 3.0]), Some(2.5));
    }
}
