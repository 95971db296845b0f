//! Measures the time of a training step. This is the only clock of the study, and no result depends on it.
//!
//! It counts the processor time of the single training thread, so that other processes do not matter.

use cpu_time::ThreadTime;
use serde::Serialize;

use super::kinematics::Form;
use super::loss::Loss;
use super::method::Method;
use super::run::{Error, Plan};
use super::samples::Samples;
use super::training::Training;
use super::two_columns;

/// Number of timed steps of every kind, and number of warm-up steps before.
const ROUNDS: usize = 60;
const WARM_UP: usize = 5;

/// Median times of a step on one thread, in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct StepTime {
    /// Number of latent units of the network.
    pub latent: usize,
    /// Method of the loss.
    pub method: Method,
    /// Form of the method's forward kinematics, if the method uses them.
    pub form: Option<Form>,
    /// Time of the whole step.
    pub step_ms: f64,
    /// Time of the batch, the network and the loss.
    pub loss_ms: f64,
    /// Time of the gradient.
    pub gradient_ms: f64,
    /// Time of the optimizer.
    pub update_ms: f64,
}

/// Times steps of every method and form, in turn, so that other work of the machine affects all of them equally.
///
/// # Errors
/// [`Error`] if a computation fails.
pub fn time_steps(plan: &Plan<'_>) -> Result<Vec<StepTime>, Error> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    let samples = Samples::new(plan.poses)?;
    let mut times = Vec::new();
    for latent in &plan.latents {
        times.extend(pool.install(|| of_latent(plan, &samples, *latent))?);
    }
    Ok(times)
}

/// A kind of step, and the times of its steps.
struct Kind {
    method: Method,
    form: Option<Form>,
    loss: Loss,
    training: Training,
    parts_ms: Vec<[f64; 3]>,
}

fn of_latent(plan: &Plan<'_>, samples: &Samples, latent: usize) -> Result<Vec<StepTime>, Error> {
    let Plan { schedule, .. } = plan;
    let skeleton = &plan.poses.skeleton;
    let mut kinds = Vec::new();
    for (method, weights) in plan.weights()? {
        let forms: Vec<Option<Form>> = if method == Method::ForwardKinematics {
            Form::ALL.into_iter().map(Some).collect()
        } else {
            vec![None]
        };
        for form in forms {
            let written = form.unwrap_or(Form::Fused);
            let loss = Loss::new(skeleton, method, &weights, schedule.position_per_m, written)?;
            let numbers = skeleton.joints.len() * two_columns::NUMBERS;
            let training = Training::new(numbers, latent, 1)?;
            kinds.push(Kind { method, form, loss, training, parts_ms: Vec::new() });
        }
    }
    for _ in 0..WARM_UP + ROUNDS {
        for Kind { loss, training, parts_ms, .. } in &mut kinds {
            let (mut part, mut parts) = (ThreadTime::now(), [0.0; 3]);
            let mut took = |index: usize| {
                let now = ThreadTime::now();
                parts[index] = 1e3 * now.duration_since(part).as_secs_f64();
                part = now;
            };
            let batch = training.batch(&samples.train, schedule.batch)?;
            let mean = training.loss(samples, &batch, loss)?;
            took(0);
            let gradients = mean.backward()?;
            took(1);
            training.update(&gradients, schedule)?;
            took(2);
            parts_ms.push(parts);
        }
    }
    Ok(kinds.iter().map(|kind| kind.time(latent)).collect())
}

impl Kind {
    fn time(&self, latent: usize) -> StepTime {
        let timed = &self.parts_ms[WARM_UP..];
        let median = |of: &dyn Fn(&[f64; 3]) -> f64| {
            let mut values: Vec<f64> = timed.iter().map(of).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        StepTime {
            latent,
            method: self.method,
            form: self.form,
            step_ms: median(&|parts| parts.iter().sum()),
            loss_ms: median(&|parts| parts[0]),
            gradient_ms: median(&|parts| parts[1]),
            update_ms: median(&|parts| parts[2]),
        }
    }
}
