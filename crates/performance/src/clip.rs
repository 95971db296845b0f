//! A clip of any skeleton, read and cleaned for a rig.

use sinew_figure::measured::{MappingSource, Measured, UnitOverrides};
use sinew_figure::pipeline::tpose;
use sinew_figure::{builtin, limb_landmark, mapping};
use sinew_mocap::damage::{LongBone, check_bones, take_out_jumps};
use sinew_mocap::files::ClipFile;
use sinew_mocap::filter::LowPass;
use sinew_mocap::resample::resample;
use sinew_mocap::{Clip, Recording, format, gaps};
use sinew_retarget::LandmarkMap;
use sinew_retarget::performer::PerformerJoints;
use sinew_retarget::skeleton::SkeletonMatch;
use thiserror::Error;

/// The longest gap that is filled, s.
const GAP_MAX_S: f64 = 0.5;

/// The longest plausible bone, m: as long as the tallest figure.
const BONE_MAX_M: f64 = 3.0;

/// Settings for the preparation of a clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipSettings {
    /// Cutoff of the low-pass filter, Hz; `None`: no filter.
    pub cutoff_hz: Option<f64>,
    /// Unit and axis that the user gives for the file.
    pub units: UnitOverrides,
}

impl Default for ClipSettings {
    fn default() -> Self {
        Self { cutoff_hz: Some(6.0), units: UnitOverrides::default() }
    }
}

/// A clip in metres, y up, without an inserted T-pose.
#[derive(Debug, Clone)]
pub struct PreparedClip {
    /// The motion of the clip.
    pub clip: Clip,
    /// Time from the first row of the file to the first frame of `clip`, s.
    pub start_s: f64,
    /// The clip's joint for each landmark.
    pub matched: SkeletonMatch,
    /// Measured size, unit and axis of the clip.
    pub measured: Measured,
    /// Notes for the user.
    pub notes: Vec<String>,
}

/// Error of a clip that cannot be prepared.
#[derive(Debug, Error)]
pub enum ClipError {
    /// The file cannot be read, or is not a motion.
    #[error(transparent)]
    Read(#[from] format::Error),
    /// There is no such file.
    #[error("{clip}: no such file, and no built-in clip: these are {}", built_in.join(", "))]
    Missing {
        /// Name that the user gave.
        clip: String,
        /// Names of the built-in clips.
        built_in: Vec<String>,
    },
    /// The rate is unknown.
    #[error(
        "{clip}: the file does not state its frame rate; expected a format that does, such as BVH"
    )]
    NoRate {
        /// Path of the file.
        clip: String,
    },
    /// The unit of length is unknown.
    #[error("{clip}: {reason}")]
    NoUnit {
        /// Path of the file.
        clip: String,
        /// Reason why the unit cannot be determined.
        reason: String,
    },
    /// Fewer than 2 frames remain.
    #[error("{clip}: expected at least 2 frames, found {frames}")]
    TooShort {
        /// Path of the file.
        clip: String,
        /// Number of frames.
        frames: usize,
    },
    /// A bone is longer than any body's.
    #[error("{clip}: {source}")]
    Bone {
        /// Path of the file.
        clip: String,
        /// The bone, and its length.
        source: LongBone,
    },
    /// A gap is too long.
    #[error("{clip}: {source}")]
    Gap {
        /// Path of the file.
        clip: String,
        /// Place and length of the gap.
        source: gaps::GapError,
    },
    /// A joint cannot be low-pass filtered.
    #[error("{clip}: {source}")]
    Filter {
        /// Path of the file.
        clip: String,
        /// The joint, and the reason.
        source: sinew_mocap::filter::FilterError,
    },
}

impl PreparedClip {
    /// Reads a clip, finds its landmarks and its unit, turns it upright, skips an inserted T-pose, removes jumps, fills
    /// gaps and applies the low-pass filter. A clip at an unusual rate is resampled to a whole number of frames per
    /// second.
    ///
    /// # Errors
    /// [`ClipError`] names the file and the expected content.
    pub fn read(file: &ClipFile, settings: ClipSettings) -> Result<Self, ClipError> {
        let name = file.path.display().to_string();
        let built_in = || builtin::clips().into_iter().find(|clip| clip.name == name);
        let recording = match format::read(&file.path) {
            Ok(recording) => Recording { name: file.name.clone(), ..recording },
            // A built-in clip is used only if there is no such file.
            Err(error) => match built_in().filter(|_| !file.path.exists()) {
                Some(clip) => clip,
                None if file.path.exists() => return Err(error.into()),
                None => {
                    let built_in = builtin::clips().into_iter().map(|clip| clip.name).collect();
                    return Err(ClipError::Missing { clip: name, built_in });
                }
            },
        };
        Self::prepare(recording, &name, settings)
    }

    fn prepare(
        recording: Recording,
        name: &str,
        settings: ClipSettings,
    ) -> Result<Self, ClipError> {
        let name = || name.to_owned();
        // Files of a known skeleton may have a rate that is not in the file.
        let known = mapping::choose(&recording.skeleton).ok();
        let known_s = known.and_then(|known| known.rate_hz).map(f64::recip);
        let matched = SkeletonMatch::of_recording(&recording);
        let by = known.map(|mapping| MappingSource { mapping, is_given: false });
        let measured = Measured::new(&recording, &matched, by, settings.units);
        let mut notes = vec![measured.to_string()];
        notes.extend(measured.warnings());
        notes.extend(recording.notes.iter().cloned());
        if let (None, Some(frame_time_s)) = (recording.frame_time_s, known_s) {
            let rate_hz = frame_time_s.recip();
            notes.push(format!(
                "taken as {rate_hz} Hz, like other files of its skeleton: the file does not state its rate"
            ));
        }
        let frame_time_s = recording.frame_time_s.or(known_s);
        let frame_time_s = frame_time_s.ok_or_else(|| ClipError::NoRate { clip: name() })?;
        notes.extend(matched.findings.iter().cloned());
        let mut recording = measured
            .apply(recording)
            .map_err(|reason| ClipError::NoUnit { clip: name(), reason })?;
        check_bones(&recording, BONE_MAX_M)
            .map_err(|source| ClipError::Bone { clip: name(), source })?;
        let origin = |body: &str| matched.joint(limb_landmark(body)?);
        let t_pose = usize::from(tpose::is_inserted(&recording, origin));
        if t_pose > 0 {
            notes.push("skipped frame 0, an inserted T-pose".to_owned());
        }
        recording.frames.drain(..t_pose);
        let frames = recording.frames.len();
        if frames < 2 {
            return Err(ClipError::TooShort { clip: name(), frames });
        }
        let jumps = take_out_jumps(&mut recording, frame_time_s).after(t_pose);
        if !jumps.is_empty() {
            notes.push(jumps.to_string());
        }
        let (mut clip, filled) =
            gaps::fill(recording, frame_time_s, GAP_MAX_S).map_err(|source| {
                let clip = if jumps.is_empty() { name() } else { format!("{}: {jumps}", name()) };
                ClipError::Gap { clip, source: source.after(t_pose) }
            })?;
        if !filled.gaps.is_empty() {
            notes.push(filled.after(t_pose).to_string());
        }
        let filter = settings.cutoff_hz.and_then(|hz| LowPass::new(clip.rate_hz(), hz));
        if let Some(filter) = filter {
            filter
                .apply_to_clip(&mut clip)
                .map_err(|source| ClipError::Filter { clip: name(), source })?;
        }
        let rate_hz = clip.rate_hz();
        // Television's rates are 1000 / 1001 of an integer; other fractions are rounding errors of the writer.
        let is_whole = |hz: f64| (hz - hz.round()).abs() < 1e-6 * hz;
        if !is_whole(rate_hz) && !is_whole(1.001 * rate_hz) {
            let whole_hz = rate_hz.round().max(1.0);
            notes.push(format!("resampled from {rate_hz:.3} to {whole_hz} Hz"));
            clip = resample(&clip, whole_hz);
        }
        Ok(Self { clip, start_s: t_pose as f64 * frame_time_s, matched, measured, notes })
    }

    /// Keeps the first `seconds` of the clip, at least two frames.
    pub fn cut(&mut self, seconds: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let frames = (seconds / self.clip.frame_time_s).ceil().max(0.0) as usize;
        self.clip.frames.truncate(frames.saturating_add(1).max(2));
    }

    /// Returns the joints of the landmarks.
    pub fn joints(&self) -> PerformerJoints {
        let joints = LandmarkMap::of(|landmark| self.matched.joint(landmark));
        PerformerJoints::of(&self.clip.skeleton, joints)
    }
}
