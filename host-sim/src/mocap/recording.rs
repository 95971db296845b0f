//! What every reader makes of a file: a motion in the file's own units.

use std::ops::RangeInclusive;
use std::path::Path;

use super::clip::{Clip, JointSample, Skeleton};
use super::mapping::Mapping;

/// Far above any mocap skeleton: what bounds the memory a small file can ask for.
pub(super) const JOINT_COUNT_MAX: usize = 1024;
/// Joints times frames, 6 GiB: an hour of 100 joints at 240 Hz.
pub(super) const SAMPLE_COUNT_MAX: usize = 100_000_000;
/// Larger offsets and angles are damage, and would overflow further on.
pub(super) const MAGNITUDE_MAX: f64 = 1e9;
/// Any camera's: what bounds the number of frames after resampling.
pub(super) const FRAME_TIME_S: RangeInclusive<f64> = 1e-5..=1.0;
/// Writers round the frame time (0.0083333, 0.016667, 0.033333): rates this near a whole number
/// are taken for it. 29.97 and 59.94 Hz, one part in 1001 off, keep their own.
const RATE_SNAP: f64 = 5e-4;

/// All frames: `frames[f][j]` is joint `j` in frame `f`, `None` where the recording has a gap.
pub(super) type Frames = Vec<Vec<Option<JointSample>>>;

/// A motion whose lengths are in the file's own unit, which only some formats tell.
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
}

/// Neither the file nor its mapping gives the frame rate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the file does not tell its frame rate, and neither does mapping `{mapping}`: expected \
     `rate_hz = 120` or the like in the mapping"
)]
pub struct NoRate {
    /// Name of the mapping.
    pub mapping: String,
}

impl Recording {
    /// The motion in metres. The mapping gives the unit and the rate where the file does not.
    ///
    /// # Errors
    /// [`NoRate`] if nothing says the rate.
    pub fn into_clip(self, mapping: &Mapping) -> Result<Clip, NoRate> {
        let Self { name, mut skeleton, mut frames, frame_time_s, metres_per_unit } = self;
        let frame_time_assumed = frame_time_s.is_none();
        let frame_time_s = frame_time_s
            .or(mapping.rate_hz.map(f64::recip))
            .ok_or_else(|| NoRate { mapping: mapping.name.clone() })?;
        let metres_per_unit = metres_per_unit.unwrap_or(mapping.metres_per_unit);
        for joint in &mut skeleton.joints {
            joint.offset_m *= metres_per_unit;
            for end in &mut joint.end_sites_m {
                *end *= metres_per_unit;
            }
        }
        for sample in frames.iter_mut().flatten().flatten() {
            sample.position_m *= metres_per_unit;
        }
        Ok(Clip { name, skeleton, frame_time_s, frame_time_assumed, frames })
    }
}

/// The name of the clip in the file at `path`.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// A frame time as a file writes it, at the whole rate where it is near to one.
pub(super) fn snapped_s(frame_time_s: f64) -> f64 {
    let rate_hz = frame_time_s.recip();
    let whole_hz = rate_hz.round();
    let snaps = (rate_hz - whole_hz).abs() <= RATE_SNAP * whole_hz;
    if snaps { whole_hz.recip() } else { frame_time_s }
}
