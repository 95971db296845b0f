//! Distances of poses to sequences: the data for a classifier by nearest neighbours, computed once for any choice of
//! sequences.

use rayon::prelude::*;
use sinew_pose_metrics::spatial::{MeasuredPose, Metric, RigMeasure, Workspace};

/// For every pose of some sequences, the distance to the nearest pose of every other sequence.
#[derive(Debug, Clone, PartialEq)]
pub struct Nearest {
    sequences: usize,
    /// Index of the first pose of each sequence among all poses.
    first: Vec<usize>,
    /// Distances by pose, then by sequence; infinite for the pose's own sequence.
    distances: Vec<f32>,
}

impl Nearest {
    /// Computes the distances between the poses of all sequences; `done` is called with numbers of pairs of poses.
    /// Pairs of sequences are computed in parallel, with the same bits for any number of threads.
    ///
    /// A line is not sampled if the straight-line distance of the joints, a lower bound of its length, shows that it
    /// cannot be the shortest. This is exact except for the rounding of f32.
    pub fn new(
        measuring: &RigMeasure<'_>,
        poses: &[Vec<MeasuredPose>],
        done: impl Fn(usize) + Sync,
    ) -> Self {
        let sequences = poses.len();
        let mut first = Vec::with_capacity(sequences);
        let mut count = 0;
        for of_sequence in poses {
            first.push(count);
            count += of_sequence.len();
        }
        let mut nearest =
            Self { sequences, first, distances: vec![f32::INFINITY; count * sequences] };
        let pairs: Vec<(usize, usize)> =
            (0..sequences).flat_map(|a| (0..a).map(move |b| (a, b))).collect();
        let between = |workspace: &mut Workspace, (a, b): &(usize, usize)| {
            let both = of_pair(measuring, &poses[*a], &poses[*b], workspace);
            done(poses[*a].len() * poses[*b].len());
            both
        };
        let found: Vec<(Vec<f32>, Vec<f32>)> =
            pairs.par_iter().map_init(Workspace::new, between).collect();
        for ((a, b), (of_a, of_b)) in pairs.iter().zip(found) {
            for (own, other, distances) in [(*a, *b, of_a), (*b, *a, of_b)] {
                for (pose, distance) in distances.into_iter().enumerate() {
                    let at = (nearest.first[own] + pose) * sequences + other;
                    nearest.distances[at] = distance;
                }
            }
        }
        nearest
    }

    /// Returns the distances of a sequence's pose to all sequences.
    pub fn of(&self, sequence: usize, pose: usize) -> &[f32] {
        let from = (self.first[sequence] + pose) * self.sequences;
        &self.distances[from..from + self.sequences]
    }
}

/// Returns for every pose of both sequences the distance to the nearest pose of the other sequence.
fn of_pair(
    measuring: &RigMeasure<'_>,
    a: &[MeasuredPose],
    b: &[MeasuredPose],
    workspace: &mut Workspace,
) -> (Vec<f32>, Vec<f32>) {
    let is_bounded = measuring.measure().metric == Metric::Line;
    let (mut of_a, mut of_b) = (vec![f32::INFINITY; a.len()], vec![f32::INFINITY; b.len()]);
    for (one, of_one) in a.iter().zip(&mut of_a) {
        for (other, of_other) in b.iter().zip(&mut of_b) {
            let to_beat = of_one.max(*of_other);
            if is_bounded && measuring.position_distance(one, other) >= to_beat {
                continue;
            }
            let distance = measuring.distance(one, other, workspace);
            *of_one = of_one.min(distance);
            *of_other = of_other.min(distance);
        }
    }
    (of_a, of_b)
}

#[cfg(test)]
mod tests {
    use sinew_pose_metrics::spatial::{Measure, SpatialRig};

    use super::*;
    use crate::recordings::Recordings;
    use crate::spatial::classes::TwoClasses;

    #[test]
    fn bounds_leave_out_nothing_that_is_nearest() {
        let mut classes = TwoClasses::of(&Recordings::built_in()).unwrap();
        classes.sequences.drain(2..9);
        for sequence in &mut classes.sequences {
            sequence.frames.truncate(20);
        }
        let rig = SpatialRig::new(&classes.skeleton, None).unwrap();
        let mut workspace = Workspace::new();
        for measure in Measure::all() {
            let measuring = RigMeasure::new(&rig, measure);
            let poses = classes.measured(&measuring).unwrap();
            let nearest = Nearest::new(&measuring, &poses, |_| ());
            for (a, of_a) in poses.iter().enumerate() {
                for (pose, one) in of_a.iter().enumerate() {
                    let of = nearest.of(a, pose);
                    for (b, of_b) in poses.iter().enumerate() {
                        if a == b {
                            assert!(of[b].is_infinite(), "its own");
                            continue;
                        }
                        let all = of_b.iter();
                        let all = all.map(|other| measuring.distance(one, other, &mut workspace));
                        let expected = all.fold(f32::INFINITY, f32::min);
                        let off = (of[b] - expected).abs();
                        assert!(off <= 1e-5 * expected, "{measure}: {} {expected}", of[b]);
                    }
                }
            }
        }
    }
}
