//! From files to the figure's motion, in one line of steps:
//! skip, fill gaps, find flips, low-pass, resample, map on the figure.

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

/// How a clip is prepared.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Rate of the figure's motion.
    pub rate_hz: f64,
    /// Rate of the frames that a show keeps, where it is lower: `rate_hz` is a multiple of it, and the
    /// motion goes smoothly through the frames.
    pub frame_rate_hz: Option<f64>,
    /// Cutoff of the low-pass.
    pub cutoff_hz: f64,
    /// What is left out at the start of every clip: recordings settle there.
    pub lead_in_s: f64,
    /// The longest gap that is filled.
    pub gap_max_s: f64,
    /// The mapping of all clips; `None` to choose a known one by the skeleton.
    pub mapping: Option<Mapping>,
    /// What the user says of the files.
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

/// From a puppet to a giant: beyond, the unit of length is wrong.
const HEIGHT_M: std::ops::RangeInclusive<f64> = 0.3..=3.0;

/// What was done to a clip that its user should know; without the clip's name.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Notice {
    /// How tall, in which unit, and which way up.
    #[error("{0}")]
    Measured(Box<Measured>),
    /// The file is not as it says, or not believable.
    #[error("{0}")]
    File(String),
    /// The mapping gave the frame rate.
    #[error("taken as {rate_hz} Hz, the mapping's `rate_hz`: the recording does not tell its rate")]
    RateAssumed {
        /// The rate.
        rate_hz: f64,
    },
    /// Nobody wrote the mapping.
    #[error("{0}")]
    MappingProposed(Proposal),
    /// Frame 0 was left out.
    #[error("skipped frame 0, an inserted T-pose")]
    TPoseSkipped,
    /// The start was left out.
    #[error("skipped the first {seconds} s ({})", counted(*frames, "frame"))]
    LeadInSkipped {
        /// Frames left out.
        frames: usize,
        /// The time asked for.
        seconds: f64,
    },
    /// Samples that no body can have were taken out.
    #[error("{0}")]
    RemovedJumps(RemovedJumps),
    /// Missing samples were made up.
    #[error("{0}")]
    GapsFilled(FilledGaps),
    /// Joints turn as no human's do.
    #[error("{0}")]
    JointFlips(Flips),
    /// The clip's rate cannot hold the cutoff.
    #[error(
        "not low-passed: a rate of {rate_hz} Hz holds nothing above the cutoff of {cutoff_hz} Hz"
    )]
    NotFiltered {
        /// Rate of the clip.
        rate_hz: f64,
        /// The cutoff asked for.
        cutoff_hz: f64,
    },
}

/// Clips that cannot be read or prepared.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file is not a motion.
    #[error(transparent)]
    Read(#[from] format::Error),
    /// The paths do not name clips.
    #[error(transparent)]
    Files(#[from] files::Error),
    /// Nothing says the frame rate.
    #[error("{clip}: {source}")]
    NoRate {
        /// The file.
        clip: String,
        /// What is missing.
        source: NoRate,
    },
    /// The skeleton cannot be mapped.
    #[error("{clip}: {source}")]
    Mapping {
        /// File or name of the clip.
        clip: String,
        /// Why not.
        source: Box<mapping::Error>,
    },
    /// A gap cannot be filled.
    #[error("{clip}: {source}")]
    Gap {
        /// Name of the clip.
        clip: String,
        /// Where, in the frames of the recording.
        source: GapError,
    },
    /// A joint cannot be low-passed.
    #[error("{clip}: {source}")]
    Filter {
        /// Name of the clip.
        clip: String,
        /// Where, in the frames of the recording.
        source: FilterError,
    },
    /// Nothing to move is left.
    #[error(
        "{clip}: too short: expected at least 2 frames at {rate_hz} Hz after the {} skipped at its start, \
         found {frames} of the recording's {}",
        counted(*skipped, "frame"), counted(*recorded, "frame")
    )]
    TooShort {
        /// Name of the clip.
        clip: String,
        /// Frames left, at the rate asked for.
        frames: usize,
        /// The rate asked for.
        rate_hz: f64,
        /// Recorded frames that were skipped: the T-pose and the lead-in.
        skipped: usize,
        /// Frames of the recording.
        recorded: usize,
    },
    /// The unit of length is not known.
    #[error("{clip}: {reason}")]
    Unit {
        /// Name of the clip.
        clip: String,
        /// Why not.
        reason: String,
    },
    /// The unit of length is wrong.
    #[error(
        "{clip}: expected a figure 0.3 to 3 m tall, found {height_m:.3} m: give the length of the file's unit with \
         --metres-per-unit, or check metres_per_unit in the mapping"
    )]
    Height {
        /// Name of the clip.
        clip: String,
        /// From the ankle to the crown.
        height_m: f64,
    },
    /// A bone is longer than the body.
    #[error("{clip}: {source}")]
    Bone {
        /// Name of the clip.
        clip: String,
        /// Which.
        source: LongBone,
    },
    /// Left and right are not of one body.
    #[error("{clip}: {source}")]
    Sides {
        /// Name of the clip.
        clip: String,
        /// Which.
        source: UnlikeSides,
    },
    /// A setting makes no sense.
    #[error("{name}: expected {expected}, found {value}")]
    Setting {
        /// The field of [`Settings`].
        name: &'static str,
        /// The values that are accepted.
        expected: &'static str,
        /// The value that was found.
        value: f64,
    },
}

impl Settings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`Error::Setting`] for a rate or cutoff that is not above zero, a time below zero, NaN or
    /// infinity.
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

    /// How many steps of the figure's motion a frame lasts.
    fn ticks_per_frame(&self) -> Result<usize, Error> {
        let Some(frame_rate_hz) = self.frame_rate_hz else { return Ok(1) };
        let factor = self.rate_hz / frame_rate_hz;
        // Beyond, the rates are no rates; written so that NaN is refused.
        if !((1.0..=1e4).contains(&factor) && (factor - factor.round()).abs() < 1e-9 * factor) {
            return Err(Error::Setting {
                name: "frame_rate_hz",
                expected: "a rate of frames that goes into the rate of control a whole number of times",
                value: frame_rate_hz,
            });
        }
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1 to 1e4")]
        Ok(factor.round() as usize)
    }
}

/// Reads one recording that can be prepared: a mapping is known for it, and its frame rate.
///
/// # Errors
/// [`Error::Read`], [`Error::Mapping`] and [`Error::NoRate`].
pub fn load(file: &ClipFile, settings: &Settings) -> Result<Recording, Error> {
    let (recording, found) = read(file, settings)?;
    let clip = || file.path.display().to_string();
    found
        .mapping
        .frame_time_s(&recording)
        .map_err(|source| Error::NoRate { clip: clip(), source })?;
    Ok(recording)
}

/// Reads one recording, and finds its mapping.
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

/// Reads all recordings that `paths` name, see [`files::expand`] and [`load`].
///
/// # Errors
/// Those of the two, for the first path that has one.
pub fn load_paths(paths: &[PathBuf], settings: &Settings) -> Result<Vec<Recording>, Error> {
    files::expand(paths)?.iter().map(|file| load(file, settings)).collect()
}

/// Skips the T-pose and the lead-in, fills gaps, looks for joint flips, low-passes, resamples and maps,
/// in this order.
///
/// The low-pass works at the clip's own rate, so that it also keeps the resampling from aliasing.
///
/// # Errors
/// [`Error::Setting`], [`Error::Mapping`], [`Error::Unit`], [`Error::Height`], [`Error::Gap`], [`Error::Filter`],
/// [`Error::TooShort`].
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
        .frame_time_s(&recording)
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
    if recording.frame_time_s.is_none() {
        notices.push(Notice::RateAssumed { rate_hz: frame_time_s.recip() });
    }
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

/// A recording in metres, y up, and how it was measured. `known`: a mapping that somebody wrote; `otherwise`: the unit
/// where nothing tells it, in metres.
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

/// What is to be said of a recording before anything is done to it.
fn noticed(measured: &Measured, recording: &mut Recording) -> Vec<Notice> {
    let of_file = recording.notes.drain(..).chain(measured.warnings()).map(Notice::File);
    std::iter::once(Notice::Measured(Box::new(measured.clone()))).chain(of_file).collect()
}

/// Refuses a recording in metres whose skeleton no body has. It is as tall as the longest of figures at most.
fn believed(clip: &str, binding: &Binding, recording: &Recording) -> Result<(), Error> {
    check_bones(recording, *HEIGHT_M.end())
        .map_err(|source| Error::Bone { clip: clip.to_owned(), source })?;
    binding.check_sides().map_err(|source| Error::Sides { clip: clip.to_owned(), source })
}

/// A gap that cannot be filled; where samples were taken out, that they were.
fn unfilled(clip: &str, jumps: &RemovedJumps, source: GapError) -> Error {
    let clip = if jumps.is_empty() {
        clip.to_owned()
    } else {
        format!("{clip}: {jumps}, and cannot be filled")
    };
    Error::Gap { clip, source }
}

/// Frames earlier than `seconds`; the small term keeps 0.1 s at 120 Hz at 12.
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
