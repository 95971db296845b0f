//! Converts files to the figure's motion in a sequence of steps: skip, remove impossible samples, fill gaps, find
//! flips, low-pass, resample, map to the figure.

mod loaded;
pub mod tpose;

use std::path::PathBuf;

use sinew_mocap::damage::{LongBone, RemovedJumps, check_bones, take_out_jumps};
use sinew_mocap::files::{self, ClipFile};
use sinew_mocap::filter::{FilterError, LowPass};
use sinew_mocap::flips::{self, Flips};
use sinew_mocap::gaps::{self, FilledGaps, GapError};
use sinew_mocap::resample::resample;
use sinew_mocap::text::counted;
use sinew_mocap::{Recording, format};

use sinew_retarget::skeleton::SkeletonMatch;

use crate::FigureMotion;
use crate::mapping::{self, Binding, ChosenMapping, Mapping, NoRate, Proposal, UnlikeSides};
use crate::measured::{MappingSource, Measured, UnitOverrides};

pub use loaded::{LoadedClip, load_clip};

/// Settings of the preparation of a clip.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Rate of the figure's motion, Hz.
    pub rate_hz: f64,
    /// Rate of a show's frames, Hz, if lower than `rate_hz`, which must be a multiple of it. The motion then
    /// passes smoothly through these frames.
    pub frame_rate_hz: Option<f64>,
    /// Cutoff of the low-pass, Hz.
    pub cutoff_hz: f64,
    /// Time omitted at the start of every clip, s, since recordings settle there.
    pub lead_in_s: f64,
    /// Longest gap that is filled, s.
    pub gap_max_s: f64,
    /// Mapping for all clips; `None` to choose a known mapping for each clip by its skeleton, or to propose a mapping
    /// if none is known.
    pub mapping: Option<Mapping>,
    /// The user's options about unit and up axis of the files.
    pub units: UnitOverrides,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            rate_hz: 100.0,
            frame_rate_hz: None,
            cutoff_hz: 6.0,
            lead_in_s: 0.1,
            gap_max_s: 0.5,
            mapping: None,
            units: UnitOverrides::default(),
        }
    }
}

/// Plausible heights in metres, from a puppet to a giant. If a height is outside, the unit of length must be wrong.
const HEIGHT_M: std::ops::RangeInclusive<f64> = 0.3..=3.0;

/// A fact about a clip, or a change that was made to it, of which the user should know. The message does not contain
/// the clip's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Notice {
    /// Height, unit and up axis of the clip.
    #[error("{0}")]
    Measured(Box<Measured>),
    /// The file contradicts its own header, or its content is implausible.
    #[error("{0}")]
    File(String),
    /// The frame rate is the mapping's.
    #[error(
        "taken as {rate_hz} Hz, the mapping's `rate_hz`: the recording does not state its rate"
    )]
    RateAssumed {
        /// Rate in Hz.
        rate_hz: f64,
    },
    /// The frame rate is the given mapping's, and the file states another.
    #[error("taken as {rate_hz} Hz, the mapping's `rate_hz`: the file says {file_hz:.3} Hz")]
    RateOverruled {
        /// Rate of the mapping, Hz.
        rate_hz: f64,
        /// Rate of the file, Hz.
        file_hz: f64,
    },
    /// The mapping is a proposal.
    #[error("{0}")]
    MappingProposed(Proposal),
    /// Frame 0 was omitted.
    #[error("skipped frame 0, an inserted T-pose")]
    TPoseSkipped,
    /// The start was omitted.
    #[error("skipped the first {seconds} s ({})", counted(*frames, "frame"))]
    LeadInSkipped {
        /// Number of frames omitted.
        frames: usize,
        /// Requested time to omit, in seconds.
        seconds: f64,
    },
    /// Samples that are impossible for a body were removed.
    #[error("{0}")]
    RemovedJumps(RemovedJumps),
    /// Missing samples were interpolated.
    #[error("{0}")]
    GapsFilled(FilledGaps),
    /// Joints turn faster than those of any human.
    #[error("{0}")]
    JointFlips(Flips),
    /// The clip's rate is too low for the cutoff.
    #[error(
        "not low-passed: a rate of {rate_hz} Hz contains nothing above the cutoff of {cutoff_hz} Hz"
    )]
    NotFiltered {
        /// Rate of the clip, Hz.
        rate_hz: f64,
        /// Requested cutoff, Hz.
        cutoff_hz: f64,
    },
}

/// The error of clips that cannot be read or prepared.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that cannot be read as a motion.
    #[error(transparent)]
    Read(#[from] format::Error),
    /// Paths that do not name clips.
    #[error(transparent)]
    Files(#[from] files::Error),
    /// A clip without a known frame rate.
    #[error("{clip}: {source}")]
    NoRate {
        /// Path of the file.
        clip: String,
        /// Details of the missing rate.
        source: NoRate,
    },
    /// A skeleton that cannot be mapped.
    #[error("{clip}: {source}")]
    Mapping {
        /// File or name of the clip.
        clip: String,
        /// Reason for the failure.
        source: Box<mapping::Error>,
    },
    /// A gap that cannot be filled.
    #[error("{clip}: {source}")]
    Gap {
        /// Name of the clip.
        clip: String,
        /// Place of the gap, in the frames of the recording.
        source: GapError,
    },
    /// A joint that cannot be low-passed.
    #[error("{clip}: {source}")]
    Filter {
        /// Name of the clip.
        clip: String,
        /// Place of the failure, in the frames of the recording.
        source: FilterError,
    },
    /// A clip with too few frames.
    #[error(
        "{clip}: too short: expected at least 2 frames at {rate_hz} Hz after the {} skipped at its start, \
         found {frames} of the recording's {}",
        counted(*skipped, "frame"), counted(*recorded, "frame")
    )]
    TooShort {
        /// Name of the clip.
        clip: String,
        /// Number of frames left, at the requested rate.
        frames: usize,
        /// Requested rate, Hz.
        rate_hz: f64,
        /// Recorded frames that were skipped: the T-pose and the lead-in.
        skipped: usize,
        /// Number of frames in the recording.
        recorded: usize,
    },
    /// A clip whose unit of length is unknown.
    #[error("{clip}: {reason}")]
    Unit {
        /// Name of the clip.
        clip: String,
        /// Reason why the unit is unknown.
        reason: String,
    },
    /// A clip whose unit of length gives an implausible height.
    #[error(
        "{clip}: expected a figure 0.3 to 3 m tall, found {height_m:.3} m: give the length of the file's unit with \
         --metres-per-unit, or check metres_per_unit in the mapping"
    )]
    Height {
        /// Name of the clip.
        clip: String,
        /// Height from the ankle to the crown.
        height_m: f64,
    },
    /// A bone that is longer than a body.
    #[error("{clip}: {source}")]
    Bone {
        /// Name of the clip.
        clip: String,
        /// Details of the bone.
        source: LongBone,
    },
    /// Left and right limbs of very different lengths.
    #[error("{clip}: {source}")]
    Sides {
        /// Name of the clip.
        clip: String,
        /// Details of the limb.
        source: UnlikeSides,
    },
    /// A setting whose value is invalid.
    #[error("{name}: expected {expected}, found {value}")]
    Setting {
        /// Name of the field of [`Settings`].
        name: &'static str,
        /// Description of the accepted values.
        expected: &'static str,
        /// Value that was found.
        value: f64,
    },
}

impl Settings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Setting`] for a rate or cutoff that is not above zero, a time below zero, NaN or infinity, or a
    /// `frame_rate_hz` that does not divide `rate_hz`.
    pub fn check(&self) -> Result<(), Error> {
        let Self { rate_hz, cutoff_hz, lead_in_s, gap_max_s, .. } = *self;
        for (name, value) in [("rate_hz", rate_hz), ("cutoff_hz", cutoff_hz)] {
            if !(value > 0.0 && value.is_finite()) {
                return Err(Error::Setting { name, expected: "a finite number above 0", value });
            }
        }
        for (name, value) in [("lead_in_s", lead_in_s), ("gap_max_s", gap_max_s)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::Setting { name, expected: "a finite number from 0", value });
            }
        }
        self.ticks_per_frame()?;
        Ok(())
    }

    /// Returns the number of steps of the figure's motion per frame of the show.
    fn ticks_per_frame(&self) -> Result<usize, Error> {
        let Some(frame_rate_hz) = self.frame_rate_hz else { return Ok(1) };
        let factor = self.rate_hz / frame_rate_hz;
        // Larger factors are implausible. The condition is written to refuse NaN.
        if !((1.0..=1e4).contains(&factor) && (factor - factor.round()).abs() < 1e-9 * factor) {
            return Err(Error::Setting {
                name: "frame_rate_hz",
                expected: "a frame rate that divides the control rate",
                value: frame_rate_hz,
            });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1e4")]
        Ok(factor.round() as usize)
    }
}

/// Reads a recording and checks that it can be prepared: that its mapping and its frame rate are known.
///
/// # Errors
/// [`Error::Read`], [`Error::Mapping`] and [`Error::NoRate`].
pub fn load(file: &ClipFile, settings: &Settings) -> Result<Recording, Error> {
    let (recording, found) = read(file, settings)?;
    let clip = || file.path.display().to_string();
    found
        .mapping
        .frame_time_s(&recording, settings.mapping.is_some())
        .map_err(|source| Error::NoRate { clip: clip(), source })?;
    Ok(recording)
}

/// Reads a recording and finds its mapping.
fn read<'a>(
    file: &ClipFile,
    settings: &'a Settings,
) -> Result<(Recording, ChosenMapping<'a>), Error> {
    let recording = Recording { name: file.name.clone(), ..format::read(&file.path)? };
    let clip = || file.path.display().to_string();
    let found = mapping::find_mapping(&recording, settings.mapping.as_ref())
        .map_err(|source| Error::Mapping { clip: clip(), source: source.into() })?;
    Ok((recording, found))
}

/// Reads all recordings that `paths` name; see [`files::expand`] and [`load`].
///
/// # Errors
/// Those of both functions, for the first path that fails.
pub fn load_paths(paths: &[PathBuf], settings: &Settings) -> Result<Vec<Recording>, Error> {
    files::expand(paths)?.iter().map(|file| load(file, settings)).collect()
}

/// Skips the T-pose and the lead-in, removes samples that are impossible for a body, fills gaps, looks for joint flips,
/// low-passes, resamples and maps, in this order.
///
/// The low-pass works at the clip's own rate, before resampling, to prevent aliasing too.
///
/// # Errors
/// [`Error::Setting`], [`Error::Mapping`], [`Error::NoRate`], [`Error::Unit`], [`Error::Height`], [`Error::Bone`],
/// [`Error::Sides`], [`Error::Gap`], [`Error::Filter`], [`Error::TooShort`].
pub fn prepare(
    recording: Recording,
    settings: &Settings,
) -> Result<(FigureMotion, Vec<Notice>), Error> {
    settings.check()?;
    let name = recording.name.clone();
    let of_mapping =
        |source: mapping::Error| Error::Mapping { clip: name.clone(), source: source.into() };
    let ChosenMapping { mapping, proposed } =
        mapping::find_mapping(&recording, settings.mapping.as_ref()).map_err(of_mapping)?;
    let mapping = &*mapping;
    let frame_time_s = mapping
        .frame_time_s(&recording, settings.mapping.is_some())
        .map_err(|source| Error::NoRate { clip: name.clone(), source })?;
    let known = proposed.is_none().then_some(mapping);
    let (mut recording, measured) = in_metres(recording, known, None, settings, &name)?;
    let binding = Binding::new(mapping, &recording.skeleton).map_err(of_mapping)?;
    let height_m = binding.height_m();
    if !HEIGHT_M.contains(&height_m) {
        return Err(Error::Height { clip: name, height_m });
    }
    believed(&name, &binding, &recording)?;
    let recorded = recording.frames.len();
    let mut notices = noticed(&measured, &mut recording);
    notices.extend(rate_notice(recording.frame_time_s, frame_time_s));
    notices.extend(proposed.map(Notice::MappingProposed));

    let t_pose = usize::from(tpose::is_inserted(&recording, |body| binding.joint_of(body)));
    if t_pose > 0 {
        notices.push(Notice::TPoseSkipped);
    }
    let lead_in = frames_within(settings.lead_in_s, frame_time_s.recip()).min(recorded - t_pose);
    if lead_in > 0 {
        notices.push(Notice::LeadInSkipped { frames: lead_in, seconds: settings.lead_in_s });
    }
    let skipped = t_pose + lead_in;
    recording.frames.drain(..skipped);

    let too_short = |frames| Error::TooShort {
        clip: name.clone(),
        frames,
        rate_hz: settings.rate_hz,
        skipped,
        recorded,
    };
    if recording.frames.is_empty() {
        return Err(too_short(0));
    }
    let jumps = take_out_jumps(&mut recording, frame_time_s).after(skipped);
    let (mut clip, filled) = gaps::fill(recording, frame_time_s, settings.gap_max_s)
        .map_err(|source| unfilled(&name, &jumps, source.after(skipped)))?;
    if !jumps.is_empty() {
        notices.push(Notice::RemovedJumps(jumps));
    }
    if !filled.gaps.is_empty() {
        notices.push(Notice::GapsFilled(filled.after(skipped)));
    }
    let flips = flips::find(&clip, &binding.turning_joints(&clip.skeleton));
    if !flips.0.is_empty() {
        notices.push(Notice::JointFlips(flips.after(skipped, clip.frame_time_s)));
    }
    let rate_hz = clip.rate_hz();
    if let Some(filter) = LowPass::new(rate_hz, settings.cutoff_hz) {
        filter.apply_to_clip(&mut clip).map_err(|mut source| {
            source.frame += skipped;
            Error::Filter { clip: name.clone(), source }
        })?;
    } else {
        notices.push(Notice::NotFiltered { rate_hz, cutoff_hz: settings.cutoff_hz });
    }
    let factor = settings.ticks_per_frame()?;
    let clip = resample(&clip, settings.rate_hz / factor as f64);
    if clip.frames.len() < 2 {
        return Err(too_short(clip.frames.len()));
    }
    let motion = binding.map(&clip);
    Ok((if factor > 1 { motion.interpolated(factor) } else { motion }, notices))
}

/// Converts a recording to metres, y up, and returns its measurements too. `known` is a mapping that is not a
/// proposal; `otherwise` is the unit in metres if nothing determines it.
fn in_metres(
    recording: Recording,
    known: Option<&Mapping>,
    otherwise: Option<f64>,
    settings: &Settings,
    clip: &str,
) -> Result<(Recording, Measured), Error> {
    let matched = SkeletonMatch::of_recording(&recording);
    let by = known.map(|mapping| MappingSource { mapping, is_given: settings.mapping.is_some() });
    let measured = Measured::new(&recording, &matched, by, settings.units).or_unit(otherwise);
    let refused = |reason| Error::Unit { clip: clip.to_owned(), reason };
    Ok((measured.apply(recording).map_err(refused)?, measured))
}

/// Returns the notices about a recording as it was read, before its preparation.
fn noticed(measured: &Measured, recording: &mut Recording) -> Vec<Notice> {
    let of_file = recording.notes.drain(..).chain(measured.warnings()).map(Notice::File);
    std::iter::once(Notice::Measured(Box::new(measured.clone()))).chain(of_file).collect()
}

/// Returns the notice about a rate that is not the file's. `own_s` is the file's time between frames.
fn rate_notice(own_s: Option<f64>, frame_time_s: f64) -> Option<Notice> {
    /// Maximum difference due to rounding by the program that wrote the file, as a share of the rate.
    const ROUNDING: f64 = 1e-3;
    let rate_hz = frame_time_s.recip();
    match own_s.map(f64::recip) {
        None => Some(Notice::RateAssumed { rate_hz }),
        Some(file_hz) => {
            let differs = (file_hz - rate_hz).abs() > ROUNDING * rate_hz;
            differs.then_some(Notice::RateOverruled { rate_hz, file_hz })
        }
    }
}

/// Refuses a recording in metres whose skeleton is impossible for a body: a bone longer than the tallest figure,
/// or very different sides.
fn believed(clip: &str, binding: &Binding, recording: &Recording) -> Result<(), Error> {
    check_bones(recording, *HEIGHT_M.end())
        .map_err(|source| Error::Bone { clip: clip.to_owned(), source })?;
    binding.check_sides().map_err(|source| Error::Sides { clip: clip.to_owned(), source })
}

/// Returns the error of a gap that cannot be filled. If samples were removed, the error mentions them.
fn unfilled(clip: &str, jumps: &RemovedJumps, source: GapError) -> Error {
    let clip = if jumps.is_empty() {
        clip.to_owned()
    } else {
        format!("{clip}: {jumps}, and cannot be filled")
    };
    Error::Gap { clip, source }
}

/// Returns the number of frames earlier than `seconds`. The small term makes 0.1 s at 120 Hz exactly 12 frames.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "not negative, and saturates"
)]
fn frames_within(seconds: f64, rate_hz: f64) -> usize {
    (seconds * rate_hz - 1e-6).ceil().max(0.0) as usize
}

#[cfg(test)]
mod tests;
