//! Finds the pair of frames of two clips whose geodesic is shortest.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::RangeInclusive;

use rayon::prelude::*;
use sinew_mocap::JointSample;

use super::pair::Pair;
use crate::geodesic::{Options, RigError, solve};

/// The permitted frames of the middle of the blend, in both clips.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FrameRanges {
    /// Frames of the first clip.
    pub a: RangeInclusive<usize>,
    /// Frames of the second clip.
    pub b: RangeInclusive<usize>,
}

/// The nearest pair of frames, and the cost of the search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    /// Frame of the first clip.
    pub a: usize,
    /// Frame of the second clip.
    pub b: usize,
    /// Length of the geodesic, m.
    pub geodesic_m: f64,
    /// Straight-line distance of the joint positions, m.
    pub positions_m: f64,
    /// Number of the solver's iterations for this pair.
    pub iterations: usize,
    /// Number of all pairs of frames.
    pub pairs: usize,
    /// Number of pairs whose geodesic was computed.
    pub solved: usize,
    /// Number of these pairs for which the solver gave up.
    pub gave_up: usize,
}

/// Number of pairs that are solved before the best pair is updated. It does not depend on the number of threads, since
/// the report contains the number of solved pairs, which must be the same on every machine.
const BATCH: usize = 4;

/// Safety factor for the rounding of f64. In exact arithmetic no curve is shorter than the straight-line distance.
const ROUNDING: f64 = 1.0 - 1e-9;

/// Returns the pair of frames with the shortest geodesic; of two equal pairs, the earlier. Pairs are visited in
/// the order of their straight-line distance, which is a lower bound of the geodesic, until that distance exceeds
/// the best geodesic: the remaining pairs cannot be better. `done` is called for every solved pair.
///
/// # Errors
/// [`RigError`] if a pose does not fit the rig.
///
/// # Panics
/// If a range is empty, or contains frames after a clip's end.
pub fn nearest(
    pair: &Pair,
    places: &FrameRanges,
    done: impl Fn(usize) + Sync,
) -> Result<Nearest, RigError> {
    let (frames_a, of_a) = moving(pair, &pair.a.frames, &places.a);
    let (frames_b, of_b) = moving(pair, &pair.b.frames, &places.b);
    // For a frame of the first clip, the nearest frame of the second that was not visited yet.
    let after = |row: usize, last: Option<(f64, usize)>| {
        let columns = of_b.iter().enumerate().map(|(column, b)| (way_m(&of_a[row], b), column));
        let rest = columns.filter(|next| last.is_none_or(|last| order(last, *next).is_lt()));
        rest.min_by(|a, b| order(*a, *b)).map(|(way_m, column)| (way_m.to_bits(), row, column))
    };
    let first: Vec<_> = (0..of_a.len()).into_par_iter().map(|row| after(row, None)).collect();
    let mut open: BinaryHeap<_> = first.into_iter().flatten().map(Reverse).collect();
    let mut best: Option<Nearest> = None;
    let (mut solved, mut gave_up) = (0, 0);
    loop {
        let limit_m = best.map_or(f64::INFINITY, |best| best.geodesic_m);
        let mut batch = Vec::with_capacity(BATCH);
        while batch.len() < BATCH
            && let Some(&Reverse((bits, row, column))) = open.peek()
            && f64::from_bits(bits) * ROUNDING <= limit_m
        {
            open.pop();
            open.extend(after(row, Some((f64::from_bits(bits), column))).map(Reverse));
            batch.push((f64::from_bits(bits), row, column));
        }
        if batch.is_empty() {
            break;
        }
        let results: Vec<_> = batch
            .par_iter()
            .map(|(_, row, column)| {
                let (a, b) = (frames_a[*row], frames_b[*column]);
                let (from, to) = (pair.pose(&pair.a.frames[a]), pair.pose(&pair.b.frames[b]));
                let geodesic = solve(&pair.rig, &from, &to, &Options::default());
                done(1);
                geodesic.map(|geodesic| (a, b, geodesic))
            })
            .collect();
        for ((positions_m, ..), result) in batch.into_iter().zip(results) {
            let (a, b, geodesic) = result?;
            solved += 1;
            gave_up += usize::from(!geodesic.converged);
            let next = Nearest {
                a,
                b,
                geodesic_m: geodesic.length_m,
                positions_m,
                iterations: geodesic.course.len(),
                pairs: places.a.clone().count() * places.b.clone().count(),
                solved: 0,
                gave_up: 0,
            };
            let key = |nearest: &Nearest| (nearest.geodesic_m.to_bits(), nearest.a, nearest.b);
            if best.is_none_or(|best| key(&next) < key(&best)) {
                best = Some(next);
            }
        }
    }
    let best = best.expect("there are places");
    Ok(Nearest { solved, gave_up, ..best })
}

/// Returns the frames of a range with the positions of all joints. A frame with the pose of its predecessor is
/// omitted: its distances are equal, and the earlier frame would be chosen. This makes clips at rest fast.
fn moving(
    pair: &Pair,
    frames: &[Vec<JointSample>],
    places: &RangeInclusive<usize>,
) -> (Vec<usize>, Vec<Vec<f64>>) {
    let poses: Vec<_> = frames[places.clone()].par_iter().map(|frame| pair.pose(frame)).collect();
    let moving = (0..poses.len()).filter(|k| *k == 0 || poses[*k] != poses[*k - 1]);
    let positions = |k: usize| {
        let all = pair.rig.positions_m(&poses[k]);
        (places.start() + k, all.into_iter().flat_map(|position| position.to_array()).collect())
    };
    moving.map(positions).unzip()
}

fn way_m(a: &[f64], b: &[f64]) -> f64 {
    libm::sqrt(a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum())
}

fn order(a: (f64, usize), b: (f64, usize)) -> std::cmp::Ordering {
    a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))
}
