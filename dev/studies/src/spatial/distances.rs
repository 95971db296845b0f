//! Computes distances between all pairs of many poses, and writes them at once.

use std::io::{self, Write};

use npyz::WriterBuilder as _;
use rayon::prelude::*;
use sinew_pose_metrics::spatial::{MeasuredPose, RigMeasure, Workspace};

/// Number of distances in memory: 16 MB.
const HELD: usize = 1 << 22;

/// Summary of the written distances.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WrittenDistances {
    /// Number of pairs of poses.
    pub pairs: usize,
    /// Sizes of the distances; `None` with fewer than two poses.
    pub distances: Option<Spread>,
}

/// Sizes of distances, in the metric's unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// The smallest distance.
    pub least: f32,
    /// The mean distance.
    pub mean: f64,
    /// The largest distance.
    pub most: f32,
}

/// Writes the distances of all pairs of poses as a NumPy file (`.npy`): f32, one dimension, (0,1), (0,2) .. (0,n-1),
/// (1,2) .., the order of SciPy's `pdist` and `squareform`. `done` is called with numbers of computed pairs.
///
/// Rows are computed in parallel, with the same bytes for any number of threads. Memory besides the poses: 16 MB of
/// distances, or one row if that is larger.
///
/// # Errors
/// An error of the writer.
pub fn write_distances(
    measuring: &RigMeasure<'_>,
    poses: &[MeasuredPose],
    out: impl Write,
    done: impl Fn(usize) + Sync,
) -> io::Result<WrittenDistances> {
    let count = poses.len();
    let pairs = count * count.saturating_sub(1) / 2;
    let shape = [pairs as u64];
    let mut npy = npyz::WriteOptions::new().default_dtype().shape(&shape).writer(out).begin_nd()?;
    let (mut least, mut most, mut sum) = (f32::INFINITY, f32::NEG_INFINITY, 0.0);
    let mut next = 0;
    while next < count {
        let of_row = |row: usize| count - 1 - row;
        let (mut end, mut held) = (next + 1, of_row(next));
        while end < count && held + of_row(end) <= HELD {
            held += of_row(end);
            end += 1;
        }
        let rows = (next..end).into_par_iter().map_init(Workspace::new, |workspace, row| {
            let found: Vec<f32> = poses[row + 1..]
                .iter()
                .map(|other| measuring.distance(&poses[row], other, workspace))
                .collect();
            done(found.len());
            found
        });
        for row in rows.collect::<Vec<_>>() {
            for distance in row {
                least = least.min(distance);
                most = most.max(distance);
                sum += f64::from(distance);
                npy.push(&distance)?;
            }
        }
        next = end;
    }
    npy.finish()?;
    let distances = (pairs > 0).then(|| Spread { least, mean: sum / pairs as f64, most });
    Ok(WrittenDistances { pairs, distances })
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use glam::DQuat;
    use sinew_figure::builtin;
    use sinew_pose_metrics::spatial::{Measure, Metric, SpatialRig};

    use super::*;

    #[test]
    fn what_is_written_are_the_distances_in_scipys_order() {
        let clip = builtin::clips().swap_remove(0);
        let rig = SpatialRig::new(&clip.skeleton, None).unwrap();
        let measuring = RigMeasure::new(&rig, Measure::new(Metric::Line));
        let frames = clip.frames.iter().step_by(40).take(6);
        let poses: Vec<MeasuredPose> = frames
            .map(|frame| {
                let rotations: Vec<DQuat> = frame.iter().map(|s| s.unwrap().rotation).collect();
                measuring.pose(&rotations).unwrap()
            })
            .collect();
        let (mut bytes, done) = (Vec::new(), AtomicUsize::new(0));
        let written = write_distances(&measuring, &poses, &mut bytes, |pairs| {
            done.fetch_add(pairs, Ordering::Relaxed);
        })
        .unwrap();
        assert_eq!((written.pairs, done.into_inner()), (15, 15));
        let read = npyz::NpyFile::new(&bytes[..]).unwrap();
        assert_eq!(read.shape(), [15]);
        let read: Vec<f32> = read.into_vec().unwrap();
        let mut workspace = Workspace::new();
        let mut expected = Vec::new();
        for a in 0..6 {
            for b in a + 1..6 {
                expected.push(measuring.distance(&poses[a], &poses[b], &mut workspace));
            }
        }
        assert_eq!(read, expected);
        let Spread { least, mean, most } = written.distances.unwrap();
        assert!(least > 0.0 && f64::from(least) < mean && mean < f64::from(most));
    }

    #[test]
    fn of_one_pose_there_is_nothing_to_write() {
        let rig = SpatialRig::new(&builtin::clips()[0].skeleton, None).unwrap();
        let measuring = RigMeasure::new(&rig, Measure::new(Metric::Angles));
        let mut bytes = Vec::new();
        let written = write_distances(&measuring, &[], &mut bytes, |_| ()).unwrap();
        assert_eq!((written.pairs, written.distances), (0, None));
        assert_eq!(npyz::NpyFile::new(&bytes[..]).unwrap().shape(), [0]);
    }
}
