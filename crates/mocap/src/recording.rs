//! The result of every file reader: a motion, still in the units of its file.

use std::ops::RangeInclusive;
use std::path::Path;

use crate::skeleton::{JointSample, Skeleton};

/// Maximum number of joints. It exceeds any motion capture skeleton, and limits the memory that a small file can
/// request.
pub(crate) const JOINT_COUNT_MAX: usize = 1024;
/// Maximum of joints times frames, 6 GiB: an hour of 100 joints at 240 Hz.
pub(crate) const SAMPLE_COUNT_MAX: usize = 100_000_000;
/// Returns the maximum number of samples (64 bytes each) for a file of `bytes` bytes. Together with all other data,
/// a reader needs less than 200 bytes of memory per byte of the file, plus 8 MB. A joint with all channels takes
/// about 10 bytes of text per frame.
pub(crate) fn sample_count_max(bytes: usize) -> usize {
    bytes.saturating_mul(2).clamp(100_000, SAMPLE_COUNT_MAX)
}

/// Maximum magnitude of an offset, a position or an angle. Larger values are regarded as damage; they would overflow
/// later.
pub(crate) const MAGNITUDE_MAX: f64 = 1e9;
/// Accepted frame times, those of any camera; they limit the number of frames after resampling.
pub(crate) const FRAME_TIME_S: RangeInclusive<f64> = 1e-5..=1.0;
/// Writers round the frame time (0.0083333, 0.016667, 0.033333): a rate within this relative distance of a whole
/// number is replaced by it. 29.97 and 59.94 Hz, which differ by 1/1001, are kept.
const RATE_SNAP: f64 = 5e-4;

/// All frames: `frames[f][j]` is joint `j` in frame `f`, `None` in a gap.
pub(crate) type Frames = Vec<Vec<Option<JointSample>>>;

/// A motion in the form of its file. Lengths are in the file's unit, which is known only for some formats.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Stem of the file.
    pub name: String,
    /// Skeleton; its lengths are in the file's unit, although their names end in `_m`.
    pub skeleton: Skeleton,
    /// Samples: `frames[f][j]` is joint `j` in frame `f`; positions are in the file's unit.
    pub frames: Vec<Vec<Option<JointSample>>>,
    /// Time between frames in seconds, if the file contains it.
    pub frame_time_s: Option<f64>,
    /// Length of the file's unit in metres, if the file contains it.
    pub metres_per_unit: Option<f64>,
    /// Errors that the reader tolerated, for the author of the file.
    pub notes: Vec<String>,
}

impl Recording {
    /// Converts lengths to metres. A file without a unit of length is assumed to be in units of `metres_per_unit`.
    #[must_use]
    pub fn in_metres(mut self, metres_per_unit: f64) -> Self {
        let metres_per_unit = self.metres_per_unit.unwrap_or(metres_per_unit);
        for joint in &mut self.skeleton.joints {
            joint.offset_m *= metres_per_unit;
            for end in &mut joint.end_sites_m {
                *end *= metres_per_unit;
            }
        }
        for sample in self.frames.iter_mut().flatten().flatten() {
            sample.position_m *= metres_per_unit;
        }
        self.metres_per_unit = Some(1.0);
        self
    }
}

/// Returns the name of the clip in the file at `path`.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Returns the frame time of the nearest whole rate, if it is near; otherwise the frame time of the file.
pub(crate) fn snapped_s(frame_time_s: f64) -> f64 {
    let rate_hz = frame_time_s.recip();
    let whole_hz = rate_hz.round();
    let snaps = (rate_hz - whole_hz).abs() <= RATE_SNAP * whole_hz;
    if snaps { whole_hz.recip() } else { frame_time_s }
}
