//! Runs all trainings of a study.

use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::{fmt, thread};

use serde::Serialize;
use sha2::{Digest as _, Sha256};
use sinew_host_util::random::{Random, Subject};

use super::anatomy::Group;
use super::checkpoint::{self, CheckpointError};
use super::data::Poses;
use super::errors::Errors;
use super::kinematics::Form;
use super::loss::Loss;
use super::method::Method;
use super::samples::{Rows, Samples, poses};
use super::training::{Schedule, Training};
use super::two_columns;
use super::weights::{WeightsError, anatomy, weights};
use crate::recordings::Pose;

/// Version of the checkpoints. Increase it when network, loss or optimizer change, because a training that began with
/// the old version must then not be resumed.
const FORMAT: u32 = 1;
/// Steps between two checkpoints.
const CHECKPOINT_STEPS: usize = 1_000;
/// Number of test poses that are shown.
const EXAMPLES: usize = 3;

/// A study: the data, the networks and their training.
#[derive(Debug, Clone)]
pub struct Plan<'a> {
    /// Poses for training and testing.
    pub poses: &'a Poses,
    /// Importance by joint of a character with a mesh; if `None`, the method with the mesh's weights is left out.
    pub character: Option<&'a [(String, f64)]>,
    /// Latent units of the networks.
    pub latents: Vec<usize>,
    /// Every network is trained with the seeds from 1 to this number.
    pub seeds: u64,
    /// Settings of the training.
    pub schedule: Schedule,
    /// Folder of the checkpoints; if `None`, an interrupted training is lost.
    pub checkpoints: Option<PathBuf>,
    /// Number of trainings in parallel. The result does not depend on it.
    pub threads: usize,
}

/// A trained network with its errors.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Outcome {
    /// Number of latent units of the network.
    pub latent: usize,
    /// Method of the network's loss.
    pub method: Method,
    /// Seed of the training.
    pub seed: u64,
    /// The network's own loss, over all training poses.
    pub train_loss: f64,
    /// The network's own loss, over all test poses.
    pub test_loss: f64,
    /// Errors over all test poses.
    pub errors: Errors,
}

/// A test pose with its reconstructions by the networks of the first seed.
#[derive(Debug, Clone, PartialEq)]
pub struct Example {
    /// Index among the test poses.
    pub index: usize,
    /// The original test pose.
    pub original: Pose,
    /// Latent units, method and reconstruction.
    pub reconstructions: Vec<(usize, Method, Pose)>,
}

/// Results of all networks.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    /// Names of the joints.
    pub joints: Vec<String>,
    /// The group of each joint.
    pub groups: Vec<Group>,
    /// The methods, each with the weights of all joints; the mean weight is 1.
    pub weights: Vec<(Method, Vec<f64>)>,
    /// Outcomes by latent units, then seeds, then methods.
    pub outcomes: Vec<Outcome>,
    /// Some of the test poses.
    pub examples: Vec<Example>,
}

/// Error of a study that cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// There are no weights for the skeleton.
    #[error(transparent)]
    Weights(#[from] WeightsError),
    /// A computation failed.
    #[error("the network: {0}")]
    Tensors(#[from] candle_core::Error),
    /// A training cannot be saved or resumed.
    #[error(transparent)]
    Checkpoint(#[from] CheckpointError),
    /// There are no poses for training or testing.
    #[error("{of}: there are no poses")]
    NoPoses {
        /// "training" or "test", for the message.
        of: &'static str,
    },
    /// The threads cannot be started.
    #[error("the threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}

impl Plan<'_> {
    /// Returns the methods for which there are weights, and the weights.
    pub(super) fn weights(&self) -> Result<Vec<(Method, Vec<f64>)>, Error> {
        let methods =
            Method::ALL.into_iter().filter(|m| *m != Method::Mesh || self.character.is_some());
        let character = self.character.unwrap_or_default();
        methods.map(|m| Ok((m, weights(&self.poses.skeleton, m, character)?))).collect()
    }

    /// Returns the number of training steps of the whole study.
    pub fn steps(&self) -> usize {
        let methods = Method::ALL.len() - usize::from(self.character.is_none());
        let seeds = usize::try_from(self.seeds).unwrap_or(usize::MAX);
        self.latents.len() * seeds * methods * self.schedule.steps
    }
}

/// A training, identified by its settings.
#[derive(Debug, Clone, Copy)]
struct Run<'a> {
    latent: usize,
    method: Method,
    seed: u64,
    weights: &'a [f64],
}

impl fmt::Display for Run<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}-{}", self.latent, self.seed, self.method.as_str())
    }
}

/// Trains all networks of a plan, or resumes from its checkpoints; `progress` is called with the number of newly
/// completed steps.
///
/// A plan gives the same bits on one machine, however often it was interrupted and with any number of threads. The
/// kernels of matrix products differ between processors, and sum in other orders.
///
/// # Errors
/// [`Error`] if weights, a training or a checkpoint fails.
pub fn run(plan: &Plan<'_>, progress: &(dyn Fn(usize) + Sync)) -> Result<Study, Error> {
    for (of, poses) in [("training", &plan.poses.train), ("test", &plan.poses.test)] {
        if poses.is_empty() {
            return Err(Error::NoPoses { of });
        }
    }
    let samples = Samples::new(plan.poses)?;
    let weights = plan.weights()?;
    let examples = examples(plan.poses.test.len());
    let runs: Vec<Run<'_>> = plan
        .latents
        .iter()
        .flat_map(|latent| (1..=plan.seeds).map(move |seed| (*latent, seed)))
        .flat_map(|(latent, seed)| {
            weights.iter().map(move |(method, weights)| Run {
                latent,
                method: *method,
                seed,
                weights,
            })
        })
        .collect();
    let finished = at_once(runs.len(), plan.threads, |index| {
        train(plan, &samples, runs[index], &examples, progress)
    })?;
    let mut shown: Vec<Example> = examples
        .iter()
        .map(|index| Example {
            index: *index,
            original: plan.poses.test[*index].clone(),
            reconstructions: Vec::new(),
        })
        .collect();
    let mut outcomes = Vec::new();
    for (outcome, reconstructions) in finished {
        if outcome.seed == 1 {
            for (example, pose) in shown.iter_mut().zip(reconstructions) {
                example.reconstructions.push((outcome.latent, outcome.method, pose));
            }
        }
        outcomes.push(outcome);
    }
    Ok(Study {
        joints: plan.poses.skeleton.joints.iter().map(|joint| joint.name.clone()).collect(),
        groups: anatomy(&plan.poses.skeleton)?.iter().map(|joint| joint.group).collect(),
        weights,
        outcomes,
        examples: shown,
    })
}

/// Returns the results of `work` for 0 to `count`, in order, computed in parallel.
///
/// Each call has a pool with one thread: the framework then splits its computations into the same parts for any
/// number of threads. They cannot share one pool, since a thread that waits for a matrix product would start another
/// training.
fn at_once<T: Send>(
    count: usize,
    threads: usize,
    work: impl Fn(usize) -> Result<T, Error> + Sync,
) -> Result<Vec<T>, Error> {
    let next = AtomicUsize::new(0);
    let results: Mutex<Vec<Option<Result<T, Error>>>> =
        Mutex::new((0..count).map(|_| None).collect());
    let pools = (0..threads.clamp(1, count.max(1)))
        .map(|_| rayon::ThreadPoolBuilder::new().num_threads(1).build())
        .collect::<Result<Vec<_>, _>>()?;
    thread::scope(|scope| {
        for pool in &pools {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    if index >= count {
                        break;
                    }
                    let result = pool.install(|| work(index));
                    results.lock().expect("no thread panics")[index] = Some(result);
                }
            });
        }
    });
    let results = results.into_inner().expect("no thread panics");
    results.into_iter().map(|result| result.expect("every index was taken")).collect()
}

/// Trains one network, and reconstructs the examples.
fn train(
    plan: &Plan<'_>,
    samples: &Samples,
    run: Run<'_>,
    examples: &[usize],
    progress: &(dyn Fn(usize) + Sync),
) -> Result<(Outcome, Vec<Pose>), Error> {
    let Plan { schedule, .. } = plan;
    let skeleton = &plan.poses.skeleton;
    let loss = Loss::new(skeleton, run.method, run.weights, schedule.position_per_m, Form::Fused)?;
    let mut training =
        Training::new(skeleton.joints.len() * two_columns::NUMBERS, run.latent, run.seed)?;
    let file = plan.checkpoints.as_ref().map(|folder| folder.join(format!("{run}.safetensors")));
    let identity = identity(plan, run);
    if let Some(file) = &file {
        checkpoint::take_up(&mut training, &identity, file)?;
        progress(training.step);
    }
    while training.step < schedule.steps {
        training.advance(samples, &loss, schedule)?;
        progress(1);
        let due = training.step % CHECKPOINT_STEPS == 0 || training.step == schedule.steps;
        if let Some(file) = file.as_ref().filter(|_| due) {
            checkpoint::save(&training, &identity, file)?;
        }
    }
    let mean = |rows: &Rows| -> Result<f64, Error> {
        Ok(f64::from(training.loss(samples, rows, &loss)?.to_scalar::<f32>()?))
    };
    let reconstructed = poses(&training.reconstruct(samples, &samples.test)?)?;
    let outcome = Outcome {
        latent: run.latent,
        method: run.method,
        seed: run.seed,
        train_loss: mean(&samples.train)?,
        test_loss: mean(&samples.test)?,
        errors: Errors::new(skeleton, &plan.poses.test, &reconstructed),
    };
    Ok((outcome, examples.iter().map(|index| reconstructed[*index].clone()).collect()))
}

/// Returns the indices of the test poses to show, in order. They are the same for every study with this number of
/// poses.
fn examples(count: usize) -> Vec<usize> {
    let mut random = Random::new(1, Subject::Examples);
    let mut indices: Vec<usize> = (0..EXAMPLES).map(|_| random.below(count)).collect();
    indices.sort_unstable();
    indices.dedup();
    indices
}

/// Returns a text with everything that a training depends on, except the machine.
fn identity(plan: &Plan<'_>, run: Run<'_>) -> String {
    let mut data = Sha256::new();
    for joint in &plan.poses.skeleton.joints {
        let parent = joint.parent.map_or(u64::MAX, |parent| parent as u64);
        data.update(parent.to_le_bytes());
        data.update(joint.offset_m.to_array().map(f64::to_le_bytes).concat());
    }
    for rotation in plan.poses.train.iter().flatten() {
        data.update(rotation.to_array().map(f64::to_le_bytes).concat());
    }
    for weight in run.weights {
        data.update(weight.to_le_bytes());
    }
    let schedule = serde_json::json!(plan.schedule);
    let digest = u64::from_be_bytes(std::array::from_fn({
        let bytes = data.finalize();
        move |index| bytes[index]
    }));
    format!("format {FORMAT}: {run} {schedule} data {digest:016x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(poses: &Poses, steps: usize, threads: usize) -> Plan<'_> {
        Plan {
            poses,
            character: None,
            latents: vec![8],
            seeds: 1,
            schedule: Schedule { steps, batch: 64, ..Schedule::default() },
            checkpoints: None,
            threads,
        }
    }

    #[test]
    fn any_number_of_threads_gives_the_same_bits() {
        let poses = Poses::built_in();
        let [one, three] = [1, 3].map(|threads| run(&plan(&poses, 12, threads), &|_| ()).unwrap());
        assert_eq!(one, three);
        let mut methods: Vec<_> = one.outcomes.iter().map(|outcome| outcome.method).collect();
        methods.dedup();
        assert_eq!(
            methods,
            [Method::Uniform, Method::ForwardKinematics, Method::Lengths, Method::Cylinders]
        );
    }

    #[test]
    fn a_training_that_was_stopped_goes_on_as_if_it_had_not() {
        let poses = Poses::built_in();
        let plan = plan(&poses, 30, 1);
        let samples = Samples::new(&poses).unwrap();
        let weights = vec![1.0; poses.skeleton.joints.len()];
        let numbers = poses.skeleton.joints.len() * two_columns::NUMBERS;
        let run = Run { latent: 8, method: Method::ForwardKinematics, seed: 4, weights: &weights };
        let loss = Loss::new(&poses.skeleton, run.method, &weights, 1.0, Form::Fused).unwrap();
        let bits = |training: &Training| -> Vec<u32> {
            let parameters = training.network.parameters().iter();
            let values = parameters.flat_map(|(_, v)| v.flatten_all().unwrap().to_vec1().unwrap());
            values.map(f32::to_bits).collect()
        };
        let advance = |training: &mut Training, until: usize| {
            while training.step < until {
                training.advance(&samples, &loss, &plan.schedule).unwrap();
            }
        };
        let new = || Training::new(numbers, run.latent, run.seed).unwrap();
        let mut unbroken = new();
        let untrained = bits(&unbroken);
        advance(&mut unbroken, 30);

        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("training.safetensors");
        let identity = identity(&plan, run);
        // Interrupted within an epoch, and in another epoch.
        for stop in [7, 22] {
            let mut stopped = new();
            checkpoint::take_up(&mut stopped, &identity, &file).unwrap();
            advance(&mut stopped, stop);
            checkpoint::save(&stopped, &identity, &file).unwrap();
        }
        let mut resumed = new();
        checkpoint::take_up(&mut resumed, &identity, &file).unwrap();
        assert_eq!(resumed.step, 22);
        advance(&mut resumed, 30);
        assert_eq!(bits(&resumed), bits(&unbroken));
        assert_ne!(bits(&resumed), untrained);

        let other = super::identity(&plan, Run { seed: 5, ..run });
        let error = checkpoint::take_up(&mut new(), &other, &file).unwrap_err();
        assert!(matches!(error, CheckpointError::Other { .. }), "{error}");
        std::fs::write(&file, "no tensors").unwrap();
        let error = checkpoint::take_up(&mut new(), &identity, &file).unwrap_err();
        assert!(matches!(error, CheckpointError::Tensors { .. }), "{error}");
    }

    #[test]
    fn a_training_is_another_one_on_another_tree() {
        let poses = Poses::built_in();
        let weights = vec![1.0; poses.skeleton.joints.len()];
        let run = Run { latent: 8, method: Method::Uniform, seed: 1, weights: &weights };
        let one = identity(&plan(&poses, 30, 1), run);
        let mut rehung = poses.clone();
        rehung.skeleton.joints[2].parent = Some(0);
        assert_ne!(rehung, poses);
        assert_ne!(identity(&plan(&rehung, 30, 1), run), one);
    }

    #[test]
    fn training_brings_errors_down() {
        let poses = Poses::built_in();
        let mean = |steps: usize| {
            let mut plan = plan(&poses, steps, 2);
            plan.schedule.rate = 5e-3;
            let study = run(&plan, &|_| ()).unwrap();
            let means = study.outcomes.iter().map(|o| o.errors.means(&study.groups, None));
            means.map(|means| means.position_cm.unwrap()).collect::<Vec<f64>>()
        };
        for (untrained, trained) in mean(1).into_iter().zip(mean(100)) {
            assert!(trained < 0.7 * untrained, "{trained} cm after {untrained}");
        }
    }
}
