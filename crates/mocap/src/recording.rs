//! What every reader makes of a file: a motion in the file's own units.

use std::ops::RangeInclusive;
use std::path::Path;

use crate::skeleton::{JointSample, Skeleton};

/// Far above any mocap skeleton: what bounds the memory a small file can ask for.
pub(crate) const JOINT_COUNT_MAX: usize = 1024;
/// Joints times frames, 6 GiB: an hour of 100 joints at 240 Hz.
pub(crate) const SAMPLE_COUNT_MAX: usize = 100_000_000;
/// Samples, of 64 bytes, that a file of so many bytes may ask for: with all else that readers hold less than 200 bytes
/// of memory for each of its own, and 8 MB. A joint whose channels are all there takes some 10 bytes of text a frame.
pub(crate) fn sample_count_max(bytes: usize) -> usize {
    bytes.saturating_mul(2).clamp(100_000, SAMPLE_COUNT_MAX)
}

/// Larger offsets and angles are damage, and would overflow further on.
pub(crate) const MAGNITUDE_MAX: f64 = 1e9;
/// Any camera's: what bounds the number of frames after resampling.
pub(crate) const FRAME_TIME_S: RangeInclusive<f64> = 1e-5..=1.0;
/// Writers round the frame time (0.0083333, 0.016667, 0.033333): rates this near a whole number
/// are taken for it. 29.97 and 59.94 Hz, one part in 1001 off, keep their own.
const RATE_SNAP: f64 = 5e-4;

/// All frames: `frames[f][j]` is joint `j` in frame `f`, `None` where the recording has a gap.
pub(crate) type Frames = Vec<Vec<Option<JointSample>>>;

/// A motion as its file holds it. Lengths are in the file's own unit, which only some formats tell.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Stem of the file.
    pub name: String,
    /// The skeleton; its "metres" are the file's unit.
    pub skeleton: Skeleton,
    /// `frames[f][j]`: joint `j` in frame `f`; positions in the file's unit.
    pub frames: Vec<Vec<Option<JointSample>>>,
    /// Time between frames in seconds, if the file says.
    pub frame_time_s: Option<f64>,
    /// Length of the file's unit in metres, if the file says.
    pub metres_per_unit: Option<f64>,
    /// What the reader overlooked, for whoever made the file.
    pub notes: Vec<String>,
}

impl Recording {
    /// Lengths in metres. A file that tells no unit of length is taken to be in units of `metres_per_unit`.
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

/// The name of the clip in the file at `path`.
pub(crate) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A frame time as a file writes it, at the whole rate where it is near to one.
pub(crate) fn snapped_s(frame_time_s: f64) -> f64 {
    let rate_hz = frame_time_s.recip();
    let whole_hz = rate_hz.round();
    let snaps = (rate_hz - whole_hz).abs() <= RATE_SNAP * whole_hz;
    if snaps { whole_hz.recip() } else { frame_time_s }
}
