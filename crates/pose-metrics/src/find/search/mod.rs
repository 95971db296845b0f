//! Searches for the moments with the smallest distances, and computes only few of all distances.

use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};
use std::ops::Range;

use rayon::prelude::*;
use sinew_batch::{LANES, PoseSequence};

use crate::spatial::{
    BODY_COUNT, MeasuredPose, Metric, RigMeasure, SpatialRig, Weighting, Workspace,
};

/// A search for a query, which is a pose or a sequence of poses, in the poses of clips. Every place of a clip
/// where the query fits is a candidate. Its distance is the root mean square of its frames' distances, which is a
/// metric if the measure is one.
///
/// A moment is a place that is nearer to the query than all other places of its clip nearby ([`Limits::apart`]). The
/// nearest moments are found exactly, after Seidl & Kriegel, "Optimal multi-step k-nearest neighbor search" (1998):
/// places are visited in the order of a lower bound of their distance, until the bound exceeds the distance of the last
/// requested moment. A sum is abandoned when it exceeds this distance. The bounds:
///
/// - for lines and geodesics, the straight-line distance, [`RigMeasure::position_distance`]: in exact arithmetic
///   no line or geodesic is shorter. Because of rounding in f32, the bound is reduced by 1e-5 of itself, and by
///   1e-5 of the distance that corresponds to the joints' reach from the root (under 0.1 mm for a figure), about a
///   hundred times the rounding.
/// - for the other measures, the sum over every eighth frame. For a single pose nothing is skipped: the distance
///   costs little more than any bound.
#[derive(Debug)]
pub struct Search<'a, const N: usize = BODY_COUNT> {
    measuring: &'a RigMeasure<'a, N>,
    query: &'a [MeasuredPose<N>],
    clips: &'a [Vec<MeasuredPose<N>>],
    /// Query and clips in the order of lanes. No clips for a query of a single pose: to store their poses again takes
    /// as long as to compare each with one pose.
    query_sequence: PoseSequence,
    sequences: Vec<PoseSequence>,
    /// Excluded places of each clip, which are not moments.
    closed: Vec<Range<usize>>,
    slack_m: f64,
}

/// The number and the spacing of the requested moments.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Number of moments.
    pub count: usize,
    /// Minimum number of frames between two moments of a clip. If two places are closer together, only the place that
    /// is nearer to the query is a moment.
    pub apart: usize,
}

/// A place in the library.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moment {
    /// Index of the clip.
    pub clip: usize,
    /// Index of the clip's pose that is compared with the query's first pose.
    pub pose: usize,
    /// Root mean square of the frames' distances, in the metric's unit.
    pub distance: f64,
}

/// Result of a search.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Moments, nearest first.
    pub moments: Vec<Moment>,
    /// Cost of the search.
    pub work: SearchStats,
}

/// Cost of a search, which does not depend on the number of threads.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SearchStats {
    /// Number of places where the query fits.
    pub places: usize,
    /// Number of distances between two poses that a complete computation would need.
    pub all: usize,
    /// Number of distances that were computed.
    pub computed: usize,
    /// Number of bounds of distances that were computed.
    pub bounds: usize,
}

impl SearchStats {
    /// Returns the share of the distances that was never computed. A distance that serves as a bound is computed again
    /// for the sum of its place; the share may therefore be zero.
    pub fn spared(&self) -> f64 {
        if self.all == 0 { 0.0 } else { (1.0 - self.computed as f64 / self.all as f64).max(0.0) }
    }
}

/// Number of places that are examined before the limit is updated, if the measure is a geodesic: small, since each
/// place takes long. [`LINES`] is the number for lines, and [`OTHERS`] for all other measures. They do not depend on
/// the number of threads, since the cost of the search is part of the result.
const GEODESICS: usize = 4;
const LINES: usize = 32;
const OTHERS: usize = 512;

/// Number of blocks whose progress is reported together: a report takes as long as the bounds of a block.
const BLOCKS: usize = 64;

/// Interval of the frames in a sum that serves as a bound.
const EVERY: usize = 8;

/// Factor for the differences between sums of equal numbers in different order, with a margin.
const SUM: f64 = 1.0 - 1e-12;

/// A place in the clips: index of the clip, and index of the pose.
type FrameTime = (usize, usize);

/// The known information about a place.
#[derive(Debug, Clone, Copy)]
enum Known {
    /// The complete squared sum of the place.
    All(f64),
    /// A lower bound of the squared sum of the place.
    AtLeast(f64),
}

impl<'a, const N: usize> Search<'a, N> {
    /// Creates a search for `query` in poses of one rig, all measured with `measuring`.
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
        Self {
            measuring,
            query,
            clips,
            query_sequence: measuring.sequence(query),
            sequences: if query.len() > 1 {
                clips.par_iter().map(|clip| measuring.sequence(clip)).collect()
            } else {
                Vec::new()
            },
            closed: vec![0..0; clips.len()],
            slack_m,
        }
    }

    /// Excludes places of a clip from the moments, such as the source of the query itself. Another place is not a
    /// moment, either, if an excluded place close to it is nearer to the query.
    #[must_use]
    pub fn without(mut self, clip: usize, poses: Range<usize>) -> Self {
        self.closed[clip] = poses;
        self
    }

    /// Returns the nearest moments; of moments at equal distance the earlier is first. `done` receives the number
    /// of newly examined places.
    pub fn nearest(&self, limits: Limits, done: impl Fn(usize) + Sync) -> Found {
        let places = self.places();
        let mut work = self.work(&places);
        let first = self.first_bounds(&places, &done);
        let mut computed = Computed::new(self.clips, &self.closed, limits);
        // Ordered by the bits of the squared sum, which have its order since it is not negative.
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

    /// Returns the nearest moments by computing every distance.
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

    /// Returns the number of places where the query fits.
    pub fn place_count(&self) -> usize {
        self.places().len()
    }

    /// Returns the places where the query fits.
    fn places(&self) -> Vec<FrameTime> {
        let of_clip = |clip: usize| self.places_of(clip).map(move |pose| (clip, pose));
        (0..self.clips.len()).flat_map(of_clip).collect()
    }

    /// Returns the places of a clip where the query fits.
    fn places_of(&self, clip: usize) -> Range<usize> {
        let (count, closed) = (self.clips[clip].len(), &self.closed[clip]);
        let is_closed = closed.start == 0 && closed.end >= count;
        let places = (count + 1).saturating_sub(self.query.len().max(1));
        0..if is_closed { 0 } else { places }
    }

    /// Divides the places into blocks whose bounds are computed together, each with the number of its clip.
    fn blocks(&self) -> Vec<(usize, Range<usize>)> {
        let of_clip = |clip: usize| {
            let places = self.places_of(clip);
            let end = places.end;
            places.step_by(LANES).map(move |first| (clip, first..(first + LANES).min(end)))
        };
        (0..self.clips.len()).flat_map(of_clip).collect()
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

    /// Returns a lower bound of the squared distance of two poses along a curve, from the straight-line distance of
    /// their joints.
    fn least(&self, way_m: f32) -> f64 {
        let least_m = (f64::from(way_m) * (1.0 - 1e-5) - self.slack_m).max(0.0);
        least_m * least_m
    }

    /// Returns what is known of each place before the search computes sums.
    fn first_bounds(
        &self,
        places: &[FrameTime],
        done: &(impl Fn(usize) + Sync),
    ) -> Vec<(Known, SearchStats)> {
        if self.sequences.is_empty() {
            let bound = |workspace: &mut Workspace<N>, (index, place): (usize, &FrameTime)| {
                tell(index, done);
                self.bound_of_pose(*place, workspace)
            };
            return places.par_iter().enumerate().map_init(Workspace::new, bound).collect();
        }
        let blocks = self.blocks();
        let bounds = |blocks: &[(usize, Range<usize>)]| {
            done(blocks.iter().map(|(_, places)| places.len()).sum());
            let of_block =
                |(clip, places): &(usize, Range<usize>)| self.bounds(*clip, places.clone());
            blocks.iter().flat_map(of_block).collect::<Vec<_>>()
        };
        blocks.par_chunks(BLOCKS).flat_map_iter(bounds).collect()
    }

    /// Returns a lower bound of the squared distance of a place to a query of a single pose, or the squared distance
    /// itself if it costs no more.
    fn bound_of_pose(
        &self,
        place: FrameTime,
        workspace: &mut Workspace<N>,
    ) -> (Known, SearchStats) {
        if !self.is_length_of_curve() {
            return self.sum(place, f64::INFINITY, workspace);
        }
        let least = |(a, b)| self.least(self.measuring.position_distance(a, b));
        let sum: f64 = self.pairs(place).map(least).sum();
        let bounds = self.query.len();
        (Known::AtLeast(sum * SUM), SearchStats { bounds, ..SearchStats::default() })
    }

    /// Returns lower bounds of the squared sums of a block of places.
    fn bounds(
        &self,
        clip: usize,
        places: Range<usize>,
    ) -> impl Iterator<Item = (Known, SearchStats)> + use<N> {
        let count = self.query.len();
        let weights = self.measuring.space().weights();
        let distances = |frame: usize| {
            let query = (&self.query_sequence, frame);
            self.sequences[clip].distances(places.start + frame, query, weights)
        };
        let is_curve = self.is_length_of_curve();
        let every = if is_curve { 1 } else { EVERY };
        let mut sums = [0.0; LANES];
        for frame in (0..count).step_by(every) {
            for (sum, distance) in sums.iter_mut().zip(distances(frame)) {
                *sum += if is_curve { self.least(distance) } else { squared(distance) };
            }
        }
        let none = SearchStats::default();
        let work = if is_curve {
            SearchStats { bounds: count, ..none }
        } else {
            SearchStats { computed: count.div_ceil(EVERY), ..none }
        };
        let bound = move |sum: f64| (Known::AtLeast(sum * SUM), work);
        sums.into_iter().take(places.len()).map(bound)
    }

    /// Computes the squared sum of a place in the order of frames, and stops when it exceeds `limit`.
    fn sum(
        &self,
        place: FrameTime,
        limit: f64,
        workspace: &mut Workspace<N>,
    ) -> (Known, SearchStats) {
        let count = self.query.len();
        let mut work = SearchStats::default();
        // Lower bounds of the sums over the frames from each frame to the end.
        let mut rest = Vec::new();
        if self.is_length_of_curve() && limit.is_finite() && count > 1 {
            let least = |(a, b)| self.least(self.measuring.position_distance(a, b));
            rest = self.pairs(place).rev().map(least).collect();
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

/// Reports places in thousands: to report each would take as long as a distance.
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
    /// Excluded places of each clip, which are not moments.
    closed: &'a [Range<usize>],
    /// Squared sums by clip and pose; NaN if unknown.
    sums: Vec<Vec<f64>>,
    /// Places in the order of their sums.
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

    /// Returns the nearest moments according to the known sums.
    fn nearest(&self) -> impl Iterator<Item = (FrameTime, f64)> {
        let all = self.order.iter().map(|(bits, place)| (*place, f64::from_bits(*bits)));
        let open = |(clip, pose): &FrameTime| !self.closed[*clip].contains(pose);
        all.filter(move |(place, sum)| open(place) && self.is_moment(*place, *sum))
            .take(self.limits.count)
    }

    /// Returns whether no place nearby has a smaller sum, and no earlier place nearby has an equal sum. An unknown sum
    /// does not count as smaller: a place whose sum is unknown when the search ends is above the limit.
    fn is_moment(&self, (clip, pose): FrameTime, sum: f64) -> bool {
        let sums = &self.sums[clip];
        let near = self.limits.apart.saturating_sub(1);
        let before = &sums[pose.saturating_sub(near)..pose];
        let after = &sums[pose + 1..(pose + 1 + near).min(sums.len())];
        !before.iter().any(|other| *other <= sum) && !after.iter().any(|other| *other < sum)
    }

    /// Returns the sum above which no place can be among the requested moments.
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
