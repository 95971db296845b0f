//! The search: the moments with the least distances, for which few of all distances are computed.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::Range;

use rayon::prelude::*;

use crate::spatial::{
    BODY_COUNT, MeasuredPose, Metric, RigMeasure, SpatialRig, Weighting, Workspace,
};

/// Poses that a query, itself some poses in a row, is searched in: every place of a clip where it fits is a moment's
/// candidate. Its distance is the root mean square of its frames' distances, which of a measure that is a metric is
/// one again.
///
/// A moment is a place that no better one of its clip is near to ([`Limits::apart`]). The nearest moments are found
/// exactly, after Seidl & Kriegel, "Optimal multi-step k-nearest neighbor search" (1998): places are visited in the
/// order of a lower bound of their distance, until that exceeds the distance of the last moment wanted; sums are
/// given up once they exceed it. The bounds:
///
/// - for lines and geodesics, the way straight through space, [`RigMeasure::position_distance`], of which in exact
///   numbers none is shorter. f32 is not exact: from the bound is taken 1e-5 of itself, and 1e-5 of what the joints'
///   reach from the root amounts to as a distance (under 0.1 mm for a figure), which is some hundred times what
///   rounding comes to.
/// - for the other measures, the sum over every eighth frame. Of a single pose there is then nothing left out: the
///   distance costs little more than any bound.
#[derive(Debug, Clone)]
pub struct Search<'a, const N: usize = BODY_COUNT> {
    measuring: &'a RigMeasure<'a, N>,
    query: &'a [MeasuredPose<N>],
    clips: &'a [Vec<MeasuredPose<N>>],
    /// Of each clip, places that are no moments.
    closed: Vec<Range<usize>>,
    slack_m: f64,
}

/// Which moments are wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// As many.
    pub count: usize,
    /// Of two places of a clip with less than so many frames between them, only the better one is a moment.
    pub apart: usize,
}

/// A place in the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// The clip.
    pub clip: usize,
    /// Its pose that the query's first one is compared with.
    pub pose: usize,
    /// Root mean square of the frames' distances, in the metric's unit.
    pub distance: f64,
}

/// What a search came to.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// The nearest first.
    pub moments: Vec<Moment>,
    /// What it took.
    pub work: SearchStats,
}

/// What a search took; the same for any number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchStats {
    /// Places where the query fits.
    pub places: usize,
    /// Distances of two poses that computing all would take.
    pub all: usize,
    /// Those that were computed.
    pub computed: usize,
    /// Bounds of such that were computed.
    pub bounds: usize,
}

impl SearchStats {
    /// The share of the distances that was never computed. Those that a bound is of are computed again with their
    /// sum, so that it may be none.
    pub fn spared(&self) -> f64 {
        if self.all == 0 { 0.0 } else { (1.0 - self.computed as f64 / self.all as f64).max(0.0) }
    }
}

/// Places that are looked at before the limit is set anew: few where each takes long. It is part of the result's
/// work, so it does not depend on threads.
const GEODESICS: usize = 4;
const LINES: usize = 32;
const OTHERS: usize = 512;

/// Of a sum that is a bound, every so many frames.
const EVERY: usize = 8;

/// What sums of the same numbers in another order may differ by, and more.
const SUM: f64 = 1.0 - 1e-12;

/// A place: clip and pose.
type FrameTime = (usize, usize);

/// What is known of a place.
#[derive(Debug, Clone, Copy)]
enum Known {
    /// Its squared sum, all of it.
    All(f64),
    /// What its squared sum is at least.
    AtLeast(f64),
}

impl<'a, const N: usize> Search<'a, N> {
    /// A search for `query` in poses of one rig, measured alike.
    pub fn new(
        rig: &SpatialRig<N>,
        measuring: &'a RigMeasure<'a, N>,
        query: &'a [MeasuredPose<N>],
        clips: &'a [Vec<MeasuredPose<N>>],
    ) -> Self {
        let mut reach_m: Vec<f64> = Vec::with_capacity(rig.tree().bodies().len());
        for body in rig.tree().bodies() {
            let own_m = body.placement.translation_m.as_dvec3().length();
            reach_m.push(own_m + body.parent.map_or(0.0, |parent| reach_m[parent]));
        }
        let weights = rig.importance().iter().map(|weight| match measuring.measure().weighting {
            Weighting::Alike => 1.0,
            Weighting::Importance => f64::from(*weight),
        });
        let squares = weights.zip(&reach_m).map(|(weight, reach_m)| weight * reach_m * reach_m);
        let slack_m = 1e-5 * libm::sqrt(squares.sum());
        Self { measuring, query, clips, closed: vec![0..0; clips.len()], slack_m }
    }

    /// Lets places of a clip be no moments: where the query itself is from. What is near to a better one of them is
    /// none either.
    #[must_use]
    pub fn without(mut self, clip: usize, poses: Range<usize>) -> Self {
        self.closed[clip] = poses;
        self
    }

    /// The nearest moments, the earlier first of those at the same distance; `done` gets how many places more were
    /// looked at.
    pub fn nearest(&self, limits: Limits, done: impl Fn(usize) + Sync) -> Found {
        let places = self.places();
        let mut work = self.work(&places);
        let first: Vec<(Known, SearchStats)> = places
            .par_iter()
            .enumerate()
            .map_init(Workspace::new, |workspace, (index, place)| {
                tell(index, &done);
                self.bound(*place, workspace)
            })
            .collect();
        let mut computed = Computed::new(self.clips, &self.closed, limits);
        // By the squared sum, whose bits are in its order as it is not negative.
        let mut open = BinaryHeap::with_capacity(places.len());
        for (index, (known, cost)) in first.into_iter().enumerate() {
            work.add(cost);
            match known {
                Known::All(sum) => computed.add(places[index], sum),
                Known::AtLeast(sum) => open.push(Reverse((sum.to_bits(), index))),
            }
        }
        let most = match self.measuring.measure().metric {
            Metric::Geodesic => GEODESICS,
            Metric::Line => LINES,
            _ => OTHERS,
        };
        loop {
            let limit = computed.limit();
            let mut batch = Vec::with_capacity(most);
            while batch.len() < most
                && let Some(&Reverse((bits, index))) = open.peek()
                && f64::from_bits(bits) <= limit
            {
                open.pop();
                batch.push(index);
            }
            if batch.is_empty() {
                break;
            }
            let results: Vec<(Known, SearchStats)> = batch
                .par_iter()
                .map_init(Workspace::new, |workspace, index| {
                    self.sum(places[*index], limit, workspace)
                })
                .collect();
            for (index, (known, cost)) in batch.into_iter().zip(results) {
                work.add(cost);
                match known {
                    Known::All(sum) => computed.add(places[index], sum),
                    Known::AtLeast(sum) => open.push(Reverse((sum.to_bits(), index))),
                }
            }
        }
        Found { moments: computed.moments(self.query.len()), work }
    }

    /// The same by computing every distance.
    pub fn nearest_of_all(&self, limits: Limits, done: impl Fn(usize) + Sync) -> Found {
        let places = self.places();
        let mut work = self.work(&places);
        let sums: Vec<(Known, SearchStats)> = places
            .par_iter()
            .enumerate()
            .map_init(Workspace::new, |workspace, (index, place)| {
                tell(index, &done);
                self.sum(*place, f64::INFINITY, workspace)
            })
            .collect();
        let mut computed = Computed::new(self.clips, &self.closed, limits);
        for (place, (known, cost)) in places.into_iter().zip(sums) {
            work.add(cost);
            if let Known::All(sum) = known {
                computed.add(place, sum);
            }
        }
        Found { moments: computed.moments(self.query.len()), work }
    }

    /// Number of places where the query fits.
    pub fn place_count(&self) -> usize {
        self.places().len()
    }

    /// Where the query fits.
    fn places(&self) -> Vec<FrameTime> {
        let length = self.query.len().max(1);
        let of_clip = |(clip, poses): (usize, &Vec<MeasuredPose<N>>)| {
            let places = 0..(poses.len() + 1).saturating_sub(length);
            let closed = self.closed[clip].clone();
            let all_closed = closed.start == 0 && closed.end >= poses.len();
            places.filter(move |_| !all_closed).map(move |pose| (clip, pose))
        };
        self.clips.iter().enumerate().flat_map(of_clip).collect()
    }

    fn work(&self, places: &[FrameTime]) -> SearchStats {
        SearchStats {
            places: places.len(),
            all: places.len() * self.query.len(),
            ..SearchStats::default()
        }
    }

    fn pairs(
        &self,
        (clip, pose): FrameTime,
    ) -> impl DoubleEndedIterator<Item = (&MeasuredPose<N>, &MeasuredPose<N>)> {
        self.query.iter().zip(&self.clips[clip][pose..pose + self.query.len()])
    }

    fn is_length_of_curve(&self) -> bool {
        self.measuring.measure().metric.is_length_of_curve()
    }

    /// What the squared distance of two poses along a curve is at least.
    fn least(&self, (a, b): (&MeasuredPose<N>, &MeasuredPose<N>)) -> f64 {
        let way_m = f64::from(self.measuring.position_distance(a, b));
        let least_m = (way_m * (1.0 - 1e-5) - self.slack_m).max(0.0);
        least_m * least_m
    }

    /// What the squared sum of a place is at least.
    fn bound(&self, place: FrameTime, workspace: &mut Workspace<N>) -> (Known, SearchStats) {
        let count = self.query.len();
        if self.is_length_of_curve() {
            let sum: f64 = self.pairs(place).map(|pair| self.least(pair)).sum();
            return (
                Known::AtLeast(sum * SUM),
                SearchStats { bounds: count, ..SearchStats::default() },
            );
        }
        if count == 1 {
            return self.sum(place, f64::INFINITY, workspace);
        }
        let some = self.pairs(place).step_by(EVERY);
        let sum: f64 = some.map(|(a, b)| squared(self.measuring.distance(a, b, workspace))).sum();
        let computed = count.div_ceil(EVERY);
        (Known::AtLeast(sum * SUM), SearchStats { computed, ..SearchStats::default() })
    }

    /// The squared sum of a place, in the order of frames; given up when it is above a limit.
    fn sum(
        &self,
        place: FrameTime,
        limit: f64,
        workspace: &mut Workspace<N>,
    ) -> (Known, SearchStats) {
        let count = self.query.len();
        let mut work = SearchStats::default();
        // What the frames from each one on come to at least.
        let mut rest = Vec::new();
        if self.is_length_of_curve() && limit.is_finite() && count > 1 {
            rest = self.pairs(place).rev().map(|pair| self.least(pair)).collect();
            for later in 1..count {
                rest[later] += rest[later - 1];
            }
            rest.reverse();
            work.bounds += count;
        }
        let mut sum = 0.0;
        for (frame, (a, b)) in self.pairs(place).enumerate() {
            let rest = rest.get(frame).copied().unwrap_or(0.0);
            let least = (sum + rest) * SUM;
            if least > limit {
                return (Known::AtLeast(least), work);
            }
            sum += squared(self.measuring.distance(a, b, workspace));
            work.computed += 1;
        }
        (Known::All(sum), work)
    }
}

/// Tells of places by the thousand: of each would take as long as a bound.
fn tell(index: usize, done: impl Fn(usize)) {
    const MANY: usize = 1000;
    if index % MANY == MANY - 1 {
        done(MANY);
    }
}

fn squared(distance: f32) -> f64 {
    f64::from(distance) * f64::from(distance)
}

impl SearchStats {
    fn add(&mut self, other: Self) {
        self.computed += other.computed;
        self.bounds += other.bounds;
    }
}

/// The places whose squared sums are known.
struct Computed<'a> {
    limits: Limits,
    /// Of each clip, places that are no moments.
    closed: &'a [Range<usize>],
    /// By clip and pose; NaN where it is not known.
    sums: Vec<Vec<f64>>,
    /// In the order of their sums.
    order: BTreeSet<(u64, FrameTime)>,
}

impl<'a> Computed<'a> {
    fn new<const N: usize>(
        clips: &[Vec<MeasuredPose<N>>],
        closed: &'a [Range<usize>],
        limits: Limits,
    ) -> Self {
        let sums = clips.iter().map(|poses| vec![f64::NAN; poses.len()]).collect();
        Self { limits, closed, sums, order: BTreeSet::new() }
    }

    fn add(&mut self, place: FrameTime, sum: f64) {
        self.sums[place.0][place.1] = sum;
        self.order.insert((sum.to_bits(), place));
    }

    /// The nearest moments, as far as is known.
    fn nearest(&self) -> impl Iterator<Item = (FrameTime, f64)> {
        let all = self.order.iter().map(|(bits, place)| (*place, f64::from_bits(*bits)));
        let open = |(clip, pose): &FrameTime| !self.closed[*clip].contains(pose);
        all.filter(move |(place, sum)| open(place) && self.is_moment(*place, *sum))
            .take(self.limits.count)
    }

    /// Whether no better place, or as good and earlier, is near. What is not known is not better: a place that is
    /// unknown when the search ends is above the limit.
    fn is_moment(&self, (clip, pose): FrameTime, sum: f64) -> bool {
        let sums = &self.sums[clip];
        let near = self.limits.apart.saturating_sub(1);
        let before = &sums[pose.saturating_sub(near)..pose];
        let after = &sums[pose + 1..(pose + 1 + near).min(sums.len())];
        !before.iter().any(|other| *other <= sum) && !after.iter().any(|other| *other < sum)
    }

    /// No place with a larger sum can be wanted.
    fn limit(&self) -> f64 {
        let mut nearest = self.nearest();
        nearest.nth(self.limits.count.saturating_sub(1)).map_or(f64::INFINITY, |(_, sum)| sum)
    }

    fn moments(&self, frames: usize) -> Vec<Moment> {
        let distance = |sum: f64| libm::sqrt(sum / frames as f64);
        self.nearest()
            .map(|((clip, pose), sum)| Moment { clip, pose, distance: distance(sum) })
            .collect()
    }
}

#[cfg(test)]
mod tests;
