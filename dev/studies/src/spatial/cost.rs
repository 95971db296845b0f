//! Measures the time of a distance. This is the only clock of the studies, and no result depends on it.
//!
//! It counts the processor time of one thread, so that other processes do not matter.

use std::hint::black_box;

use cpu_time::ThreadTime;
use serde_json::{Value, json};
use sinew_pose_metrics::spatial::{Measure, RigMeasure, SpatialRig, Workspace};

use super::classes::{ClassesError, TwoClasses};

/// Number of poses whose pairs are timed, number of timed rounds, and number of warm-up rounds before.
const POSES: usize = 48;
const ROUNDS: usize = 15;
const WARM_UP: usize = 2;

/// Median times of a measure on one thread.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    /// Time of a distance between two prepared poses, ns.
    pub distance_ns: f64,
    /// Time to prepare a pose, ns.
    pub pose_ns: f64,
}

/// Times all measures in turn, on poses from all sequences, so that other work of the machine affects all of them
/// equally.
///
/// # Errors
/// [`ClassesError`] if a pose cannot be compared.
pub fn of(
    classes: &TwoClasses,
    rig: &SpatialRig,
    measures: &[Measure],
) -> Result<Vec<Cost>, ClassesError> {
    let frames: Vec<_> = classes.sequences.iter().flat_map(|sequence| &sequence.frames).collect();
    let apart = frames.len().div_ceil(POSES).max(1);
    let mut some = classes.clone();
    some.sequences.truncate(1);
    for sequence in &mut some.sequences {
        sequence.frames = frames.iter().step_by(apart).map(|frame| (*frame).clone()).collect();
    }
    let mut workspace = Workspace::new();
    let mut times_ns = vec![[Vec::new(), Vec::new()]; measures.len()];
    for round in 0..WARM_UP + ROUNDS {
        for (measure, [distances_ns, poses_ns]) in measures.iter().zip(&mut times_ns) {
            let measuring = RigMeasure::new(rig, *measure);
            let start = ThreadTime::now();
            let measured = some.measured(&measuring)?;
            let ready = ThreadTime::now();
            let poses: Vec<_> = measured.iter().flatten().collect();
            for (index, a) in poses.iter().enumerate() {
                for b in &poses[..index] {
                    black_box(measuring.distance(a, b, &mut workspace));
                }
            }
            let end = ThreadTime::now();
            if round >= WARM_UP {
                let each = |from: ThreadTime, to: ThreadTime, count: usize| {
                    1e9 * to.duration_since(from).as_secs_f64() / count.max(1) as f64
                };
                poses_ns.push(each(start, ready, poses.len()));
                distances_ns.push(each(
                    ready,
                    end,
                    poses.len() * poses.len().saturating_sub(1) / 2,
                ));
            }
        }
    }
    let costs = times_ns.into_iter().map(|[distances_ns, poses_ns]| Cost {
        distance_ns: median(distances_ns),
        pose_ns: median(poses_ns),
    });
    Ok(costs.collect())
}

/// Returns costs as JSON.
pub(super) fn json(measures: &[Measure], costs: &[Cost]) -> Value {
    let cost = |(measure, cost): (&Measure, &Cost)| {
        json!({
            "measure": measure.to_string(),
            "distance_ns": cost.distance_ns,
            "pose_ns": cost.pose_ns,
        })
    };
    measures.iter().zip(costs).map(cost).collect()
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}
