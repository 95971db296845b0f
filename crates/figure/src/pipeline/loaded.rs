//! Clips on their own skeletons, for commands that compare and join motions.

use sinew_mocap::damage::take_out_jumps;
use sinew_mocap::files::ClipFile;
use sinew_mocap::{Clip, Recording, format, gaps};

use super::{Error, Notice, Settings, believed, in_metres, noticed, rate_notice, tpose, unfilled};
use crate::mapping::{self, Binding, Mapping, NoRate};

/// A clip on its own skeleton at its own rate, with further facts from its file.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadedClip {
    /// The motion. Its first frame is the first that is not an inserted T-pose.
    pub clip: Clip,
    /// Number of the file's frames before the first frame of `clip`.
    pub skipped: usize,
    /// Length of the file's unit, in metres.
    pub metres_per_unit: f64,
    /// Mapping of the skeleton to the figure; `None` if the skeleton is not human.
    pub mapping: Option<Mapping>,
}

/// Unit of a skeleton if neither the file nor the height determines it, in metres.
const UNIT_M: f64 = 0.01;

/// Reads a clip of any skeleton, skips an inserted T-pose, removes samples that are impossible for a body, and fills
/// gaps. It does not low-pass or resample.
///
/// # Errors
/// [`Error::Read`], [`Error::Mapping`] if the given mapping does not fit, [`Error::NoRate`], [`Error::Unit`],
/// [`Error::Bone`], [`Error::Sides`], [`Error::Gap`]; [`Error::TooShort`] if there is no frame.
pub fn load_clip(file: &ClipFile, settings: &Settings) -> Result<(LoadedClip, Vec<Notice>), Error> {
    let recording = Recording { name: file.name.clone(), ..format::read(&file.path)? };
    let name = || file.path.display().to_string();
    let of_mapping =
        |source: mapping::Error| Error::Mapping { clip: name(), source: source.into() };
    // A skeleton that is not human has no mapping.
    let found = mapping::find_mapping(&recording, settings.mapping.as_ref()).ok();
    let (mapping, proposed) =
        found.map_or((None, None), |found| (Some(found.mapping.into_owned()), found.proposed));
    let no_rate = |source| Error::NoRate { clip: name(), source };
    let frame_time_s = match &mapping {
        Some(mapping) => mapping.frame_time_s(&recording, settings.mapping.is_some()),
        None => recording.frame_time_s.ok_or_else(|| NoRate { mapping: String::new() }),
    }
    .map_err(no_rate)?;
    let known = mapping.as_ref().filter(|_| proposed.is_none());
    // The unit of a human body can be inferred from its height; if not, the clip is refused.
    let otherwise = mapping.is_none().then_some(UNIT_M);
    let (mut recording, measured) = in_metres(recording, known, otherwise, settings, &name())?;
    let metres_per_unit = measured.metres_per_unit.unwrap_or(UNIT_M);
    let binding = match &mapping {
        None => None,
        Some(mapping) => Some(Binding::new(mapping, &recording.skeleton).map_err(of_mapping)?),
    };
    if let Some(binding) = &binding {
        believed(&name(), binding, &recording)?;
    }
    let mut notices = noticed(&measured, &mut recording);
    notices.extend(proposed.map(Notice::MappingProposed));
    notices.extend(rate_notice(recording.frame_time_s, frame_time_s));
    let recorded = recording.frames.len();
    let skipped =
        usize::from(tpose::is_inserted(&recording, |body| binding.as_ref()?.joint_of(body)));
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
        notices.push(Notice::RemovedJumps(jumps));
    }
    if !filled.gaps.is_empty() {
        notices.push(Notice::GapsFilled(filled.after(skipped)));
    }
    Ok((LoadedClip { clip, skipped, metres_per_unit, mapping }, notices))
}
