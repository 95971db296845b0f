//! A clip of any skeleton, read and cleaned for a rig.

use glam::{DQuat, DVec3};
use sinew_mocap::damage::{LongBone, check_bones, take_out_jumps};
use sinew_mocap::files::ClipFile;
use sinew_mocap::filter::LowPass;
use sinew_mocap::resample::resample;
use sinew_mocap::{Clip, Recording, format, gaps};
use sinew_retarget::performer::PerformerJoints;
use sinew_retarget::skeleton::SkeletonMatch;
use sinew_retarget::{Landmark, LandmarkMap, Side};
use thiserror::Error;

use crate::builtin;
use crate::figure::mapping;
use crate::pipeline::tpose;

/// The longest gap that is filled, s.
const GAP_MAX_S: f64 = 0.5;

/// The longest bone that is believed, m: as long as the tallest figure.
const BONE_MAX_M: f64 = 3.0;

/// How a clip is prepared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ClipSettings {
    /// Cutoff of the low-pass, Hz; `None`: the frames as they are.
    pub cutoff_hz: Option<f64>,
    /// Length of the file's unit, m, where it is known.
    pub metres_per_unit: Option<f64>,
}

impl Default for ClipSettings {
    fn default() -> Self {
        Self { cutoff_hz: Some(6.0), metres_per_unit: None }
    }
}

/// A clip in metres, y up, without an inserted T-pose.
#[derive(Debug, Clone)]
pub struct PreparedClip {
    /// The motion.
    pub clip: Clip,
    /// Time of its first frame, from the first row of the file, s.
    pub start_s: f64,
    /// Which joint is which landmark.
    pub matched: SkeletonMatch,
    /// What a person should know.
    pub notes: Vec<String>,
}

/// Why a clip was not prepared.
#[derive(Debug, Error)]
pub enum ClipError {
    /// The file is no motion.
    #[error(transparent)]
    Read(#[from] format::Error),
    /// There is no such file.
    #[error("{clip}: no such file, and no built-in clip: these are {}", built_in.join(", "))]
    Missing {
        /// What was asked for.
        clip: String,
        /// The built-in clips.
        built_in: Vec<String>,
    },
    /// Nothing tells the rate.
    #[error(
        "{clip}: the file does not tell its frame rate; expected a format that does, such as BVH"
    )]
    NoRate {
        /// The file.
        clip: String,
    },
    /// Nothing tells the unit of length.
    #[error("{clip}: the unit of length is not known: {reason}; give it with --metres-per-unit")]
    NoUnit {
        /// The file.
        clip: String,
        /// What was seen.
        reason: String,
    },
    /// Too little is left.
    #[error("{clip}: expected at least 2 frames, found {frames}")]
    TooShort {
        /// The file.
        clip: String,
        /// Frames.
        frames: usize,
    },
    /// A bone is longer than any body.
    #[error("{clip}: {source}")]
    Bone {
        /// The file.
        clip: String,
        /// Which.
        source: LongBone,
    },
    /// A gap is too long.
    #[error("{clip}: {source}")]
    Gap {
        /// The file.
        clip: String,
        /// Where.
        source: gaps::Unfillable,
    },
    /// A joint cannot be low-passed.
    #[error("{clip}: {source}")]
    Filter {
        /// The file.
        clip: String,
        /// Where.
        source: sinew_mocap::filter::RotationsCancel,
    },
}

impl PreparedClip {
    /// Reads a clip, finds its landmarks and its unit, turns it upright, skips an inserted T-pose, fills gaps and
    /// low-passes.
    ///
    /// # Errors
    /// [`ClipError`] names the file and what would be right.
    pub fn read(file: &ClipFile, settings: ClipSettings) -> Result<Self, ClipError> {
        let name = file.path.display().to_string();
        let built_in = || builtin::clips().into_iter().find(|clip| clip.name == name);
        let recording = match format::read(&file.path) {
            Ok(recording) => Recording { name: file.name.clone(), ..recording },
            // Only where there is no such file.
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
        // A known skeleton's files may have a rate that they do not tell.
        let known = mapping::choose(&recording.skeleton).ok();
        let known_s = known.and_then(|known| known.rate_hz).map(f64::recip);
        let mut notes = recording.notes.clone();
        if let (None, Some(frame_time_s)) = (recording.frame_time_s, known_s) {
            let rate_hz = frame_time_s.recip();
            notes.push(format!(
                "taken as {rate_hz} Hz, as its skeleton's files: the file does not tell its rate"
            ));
        }
        let frame_time_s = recording.frame_time_s.or(known_s);
        let frame_time_s = frame_time_s.ok_or_else(|| ClipError::NoRate { clip: name() })?;
        let matched = SkeletonMatch::of_recording(&recording);
        notes.extend(matched.findings.iter().cloned());
        let metres_per_unit = unit(&recording, &matched, settings.metres_per_unit)
            .map_err(|reason| ClipError::NoUnit { clip: name(), reason })?;
        let mut recording = recording.in_metres(metres_per_unit);
        check_bones(&recording, BONE_MAX_M)
            .map_err(|source| ClipError::Bone { clip: name(), source })?;
        if let Some(turn) = matched.up.as_ref().and_then(|up| to_y_up(up.axis)) {
            notes.push("turned: the file's z axis points up".to_owned());
            turn_all(&mut recording, turn);
        }
        let origin = |body: &str| matched.joint(landmark_of(body)?);
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
        // Television's rates are 1000 / 1001 of a whole one; others that are not whole are roundings of a writer.
        let is_whole = |hz: f64| (hz - hz.round()).abs() < 1e-6 * hz;
        if !is_whole(rate_hz) && !is_whole(1.001 * rate_hz) {
            let whole_hz = rate_hz.round().max(1.0);
            notes.push(format!("resampled from {rate_hz:.3} to {whole_hz} Hz"));
            clip = resample(&clip, whole_hz);
        }
        Ok(Self { clip, start_s: t_pose as f64 * frame_time_s, matched, notes })
    }

    /// Keeps the first `seconds` of it.
    pub fn cut(&mut self, seconds: f64) {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "saturates")]
        let frames = (seconds / self.clip.frame_time_s).ceil().max(0.0) as usize;
        self.clip.frames.truncate(frames.saturating_add(1).max(2));
    }

    /// The joints of the landmarks.
    pub fn joints(&self) -> PerformerJoints {
        let joints = LandmarkMap::of(|landmark| self.matched.joint(landmark));
        PerformerJoints::of(&self.clip.skeleton, joints)
    }
}

/// Length of the file's unit in m: the caller's, the file's own, that of a known skeleton, or by the body's height.
fn unit(recording: &Recording, matched: &SkeletonMatch, given: Option<f64>) -> Result<f64, String> {
    let known = || mapping::choose(&recording.skeleton).ok().map(|mapping| mapping.metres_per_unit);
    let by_height = matched.unit.as_ref().and_then(|unit| unit.metres_per_unit);
    given.or(recording.metres_per_unit).or_else(known).or(by_height).ok_or_else(|| {
        let unit = matched.unit.as_ref().map(|unit| unit.reason.clone());
        unit.unwrap_or_else(|| "the skeleton has no arms and legs that tell its height".to_owned())
    })
}

/// The turn that brings the axis that points up to y; `None` if it does.
fn to_y_up(axis: DVec3) -> Option<DQuat> {
    (axis.y < 0.9).then(|| DQuat::from_rotation_arc(axis, DVec3::Y))
}

fn turn_all(recording: &mut Recording, turn: DQuat) {
    for root in recording.frames.iter_mut().filter_map(|frame| frame.first_mut()?.as_mut()) {
        root.rotation = turn * root.rotation;
        root.position_m = turn * root.position_m;
    }
}

/// The landmark at the origin of a limb's body of the figure.
fn landmark_of(body: &str) -> Option<Landmark> {
    let (part, side) = body.rsplit_once('_')?;
    let side = if side == "l" { Side::Left } else { Side::Right };
    Some(match part {
        "upper_arm" => Landmark::Shoulder(side),
        "forearm" => Landmark::Elbow(side),
        "hand" => Landmark::Wrist(side),
        "thigh" => Landmark::Hip(side),
        "shank" => Landmark::Knee(side),
        "foot" => Landmark::Ankle(side),
        _ => return None,
    })
}
