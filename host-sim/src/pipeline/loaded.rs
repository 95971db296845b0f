//! Clips on their own skeletons, for what compares and joins motions.

use sinew_mocap::damage::take_out_jumps;
use sinew_mocap::files::ClipFile;
use sinew_mocap::{Clip, gaps};

use super::{Error, Notice, Settings, believed, read, tpose, unfilled};
use crate::figure::mapping::{Binding, Mapping};

/// A clip on its own skeleton at its own rate, and what its file tells besides.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedClip {
    /// The motion; its first frame is the first that is no inserted T-pose.
    pub clip: Clip,
    /// Frames of the file before that.
    pub skipped: usize,
    /// Length of the file's unit, in metres.
    pub metres_per_unit: f64,
    /// How the skeleton maps on the figure.
    pub mapping: Mapping,
}

/// Reads one clip, skips an inserted T-pose and fills gaps. It is neither low-passed nor resampled.
///
/// # Errors
/// [`Error::Read`], [`Error::Mapping`], [`Error::NoRate`], [`Error::Gap`]; [`Error::TooShort`] if there is no frame.
pub fn load_clip(file: &ClipFile, settings: &Settings) -> Result<(LoadedClip, Vec<Notice>), Error> {
    let (recording, mapping) = read(file, settings)?;
    let name = || file.path.display().to_string();
    let metres_per_unit = recording.metres_per_unit.unwrap_or(mapping.metres_per_unit);
    let frame_time_s = mapping
        .frame_time_s(&recording)
        .map_err(|source| Error::NoRate { clip: name(), source })?;
    let mut recording = recording.in_metres(mapping.metres_per_unit);
    let binding = Binding::new(mapping, &recording.skeleton)
        .map_err(|source| Error::Mapping { clip: name(), source: source.into() })?;
    believed(&name(), &binding, &recording)?;
    let mut notices: Vec<_> = recording.notes.drain(..).map(Notice::File).collect();
    if recording.frame_time_s.is_none() {
        notices.push(Notice::RateAssumed { rate_hz: frame_time_s.recip() });
    }
    let recorded = recording.frames.len();
    let skipped = usize::from(tpose::is_inserted(&recording, |body| binding.joint_of(body)));
    if skipped > 0 {
        notices.push(Notice::TPoseSkipped);
    }
    recording.frames.drain(..skipped);
    if recording.frames.is_empty() {
        let rate_hz = frame_time_s.recip();
        return Err(Error::TooShort { clip: name(), frames: 0, rate_hz, skipped, recorded });
    }
    let jumps = take_out_jumps(&mut recording, frame_time_s).after(skipped);
    let (clip, filled) = gaps::fill(recording, frame_time_s, settings.gap_max_s)
        .map_err(|source| unfilled(&name(), &jumps, source.after(skipped)))?;
    if !jumps.is_empty() {
        notices.push(Notice::Jumps(jumps));
    }
    if !filled.gaps.is_empty() {
        notices.push(Notice::GapsFilled(filled.after(skipped)));
    }
    Ok((LoadedClip { clip, skipped, metres_per_unit, mapping: mapping.clone() }, notices))
}
