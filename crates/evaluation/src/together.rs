//! Runs side by side: the exact plants and the trackers of several runs take their steps together, in vector
//! instructions.

use std::array::from_fn;
use std::cmp::Reverse;

use rayon::prelude::*;
use sinew_figure::plant::{ArticulatedPlant, LANES};

use super::error::RunError;
use super::motion::{EvaluatedMotion, count_steps};
use super::run::{Performer, Run};
use super::setup::Setup;
use super::step::Step;
use super::trackers::RunTrackers;

/// A run that is to be made: a motion, its number, which selects its noise, and a setup.
#[derive(Clone, Copy)]
pub(super) struct Job<'a> {
    pub(super) motion: &'a dyn EvaluatedMotion,
    pub(super) stream: u64,
    pub(super) setup: &'a Setup,
}

/// A run among others, its results so far, and why it failed.
struct Tracked<'a, R> {
    job: Job<'a>,
    performer: Performer<'a>,
    results: R,
    failure: Option<RunError>,
}

impl<R> Tracked<'_, R> {
    fn goes_on(&self) -> bool {
        self.failure.is_none() && !self.performer.is_done()
    }
}

/// Tracks all jobs in parallel, in each thread several together. Returns their results and numbers of steps in the
/// order of the jobs. Each run has the result of the run alone, so the results do not depend on the number of threads.
///
/// `observe` receives each step, with the results so far of its run. `progress` receives the number of steps of runs
/// that were completed.
pub(super) fn track_all<R: Default + Send>(
    jobs: &[Job<'_>],
    seconds: Option<f64>,
    observe: impl Fn(&Job<'_>, &mut R, Step<'_>) + Sync,
    progress: impl Fn(usize) + Sync,
) -> Vec<Result<R, RunError>> {
    let groups = make_groups(jobs, seconds);
    let mut results: Vec<_> = groups
        .into_par_iter()
        .flat_map_iter(|group| {
            let of_group: Vec<Job<'_>> = group.iter().map(|job| jobs[*job]).collect();
            let results = track_together(&of_group, seconds, &observe, &progress);
            group.into_iter().zip(results)
        })
        .collect();
    results.sort_by_key(|(job, _)| *job);
    results.into_iter().map(|(_, result)| result).collect()
}

/// Divides jobs into groups that are tracked together. A group has at most as many jobs as the plant has lanes, and
/// fewer if a thread would otherwise have no work. Its jobs have the same substeps and trackers of the same kind, which
/// is a condition for lanes, and similar lengths, so that few lanes wait for others.
pub(super) fn make_groups(jobs: &[Job<'_>], seconds: Option<f64>) -> Vec<Vec<usize>> {
    let kind = |job: &usize| {
        let setup = jobs[*job].setup;
        (setup.plant.substeps, setup.plain_tracker())
    };
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by_key(|job| (kind(job), Reverse(count_steps(jobs[*job].motion, seconds))));
    let most = jobs.len().div_ceil(rayon::current_num_threads()).clamp(1, LANES);
    // Groups of similar size: a single run has no lanes.
    let divide = |jobs: &'_ [usize]| jobs.len().div_ceil(jobs.len().div_ceil(most));
    let of_kinds = order.chunk_by(|a, b| kind(a) == kind(b));
    of_kinds.flat_map(|jobs| jobs.chunks(divide(jobs))).map(<[usize]>::to_vec).collect()
}

/// Tracks up to [`LANES`] jobs. If their rigs are figures of ball joints, their plants take their steps together;
/// otherwise the runs are tracked one after the other. If trackers can take their ticks together, too, they do so
/// ([`Setup::plain_tracker`]). Arguments and results are those of [`track_all`].
pub(super) fn track_together<'a, R: Default>(
    jobs: &[Job<'a>],
    seconds: Option<f64>,
    observe: impl Fn(&Job<'_>, &mut R, Step<'_>),
    progress: impl Fn(usize),
) -> Vec<Result<R, RunError>> {
    let runs: Vec<_> =
        jobs.iter().map(|job| Run::new(job.motion, job.setup, seconds, job.stream)).collect();
    let Some(mut plant) = join(&runs) else {
        let track = |(job, run): (&Job<'_>, Result<Run<'_>, RunError>)| {
            let mut results = R::default();
            progress(run?.track(|step| observe(job, &mut results, step))?);
            Ok(results)
        };
        return jobs.iter().zip(runs).map(track).collect();
    };
    let start = |(job, run): (&Job<'a>, Result<Run<'a>, RunError>)| {
        let performer = run?.performer;
        Ok(Tracked { job: *job, performer, results: R::default(), failure: None })
    };
    let mut tracked: Vec<_> = jobs.iter().zip(runs).map(start).collect();
    let mut lanes: Vec<&mut Tracked<'_, R>> = tracked.iter_mut().flatten().collect();
    let mut performers: Vec<_> = lanes.iter_mut().map(|one| &mut one.performer).collect();
    let mut trackers = RunTrackers::join(&mut performers);
    let last = lanes.len() - 1;
    while lanes.iter().any(|one| one.goes_on()) {
        if let Some(trackers) = &mut trackers {
            for (lane, one) in lanes.iter_mut().enumerate().filter(|(_, one)| one.goes_on()) {
                RunTrackers::sense(&mut one.performer, plant.poses_of(lane));
            }
            trackers.step(from_fn(|lane| &lanes[lane.min(last)].performer));
        }
        for (lane, one) in lanes.iter_mut().enumerate().filter(|(_, one)| one.goes_on()) {
            let poses = plant.poses_of(lane);
            let done = if let Some(trackers) = &trackers {
                trackers.act(lane, &mut one.performer, poses)
            } else {
                one.performer.sense(poses);
                one.performer.act(poses)
            };
            one.failure = done.err();
        }
        plant.step_all(from_fn(|lane| lanes[lane.min(last)].performer.drive()));
        for (lane, one) in lanes.iter_mut().enumerate().filter(|(_, one)| one.goes_on()) {
            match one.performer.compare(plant.poses_of(lane)) {
                Ok(step) => {
                    let tracker = step.tracker.filter(|_| trackers.is_none());
                    observe(&one.job, &mut one.results, Step { tracker, ..step });
                }
                Err(error) => one.failure = Some(error),
            }
            if one.failure.is_none() && one.performer.is_done() {
                progress(one.performer.steps());
            }
        }
    }
    let end = |one: Result<Tracked<'_, R>, RunError>| {
        let Tracked { results, failure, .. } = one?;
        failure.map_or(Ok(results), Err)
    };
    tracked.into_iter().map(end).collect()
}

/// Joins the exact plants of several runs, the last of which may have several lanes. Returns `None` for another plant,
/// for a single run, and for rigs with other joints than ball joints.
fn join(runs: &[Result<Run<'_>, RunError>]) -> Option<ArticulatedPlant<LANES>> {
    let plants = runs.iter().flatten().map(|run| run.plant.as_articulated());
    let plants: Vec<&ArticulatedPlant> = plants.collect::<Option<_>>()?;
    let last = plants.len().checked_sub(1).filter(|last| *last > 0)?;
    ArticulatedPlant::join(from_fn(|lane| plants[lane.min(last)]))
}
