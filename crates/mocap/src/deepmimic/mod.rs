//! Reads the text motions of `DeepMimic` (X. B. Peng et al., 2018): `humanoid3d_*.txt`.
//!
//! A file is a JSON object with `Loop` ("wrap" or "none") and `Frames`: rows of 44 numbers, which are the time to
//! the next frame (s), the root's position (m) and rotation, and the rotations of the joints in the order of
//! [`skeleton`]. Spherical joints have a quaternion `w x y z`; knees and elbows have an angle about z (rad). y
//! points up, x forward, z to the right.
//!
//! The motion is read once, even if it is marked to wrap. The time of the last row is not used, because no frame
//! follows it. If the times differ, the motion is resampled at the shortest of them, with rotations along the great
//! arc and positions along the line.

mod error;
pub mod skeleton;

use std::path::Path;

use glam::{DQuat, DVec3};
use serde::Deserialize;

pub use error::{Error, Problem};
use skeleton::{JOINTS, Kind};

use super::recording::{self, FRAME_TIME_S, MAGNITUDE_MAX, Recording};
use crate::encoding;
use crate::skeleton::JointSample;

/// Length of a row.
const ROW: usize = 44;
/// Accepted norms of quaternions. Hand-edited frames contain blends of quaternions, with norms down to 0.58 in
/// `humanoid3d_kick.txt`; these are normalized, as in `DeepMimic`. Other norms are not rotations.
const NORM: std::ops::RangeInclusive<f64> = 0.5..=1.5;
/// Relative difference up to which two times are equal except for rounding.
const TIME_ROUNDING: f64 = 1e-3;
/// Maximum ratio of two times, which limits the number of frames that a small file can request.
const TIME_RATIO_MAX: f64 = 100.0;

#[derive(Deserialize)]
struct File {
    #[serde(rename = "Loop", default)]
    _loop: Loop,
    #[serde(rename = "Frames")]
    frames: Vec<Vec<f64>>,
}

/// Value of `Loop`, which some files of this format do not have.
#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Loop {
    Wrap,
    #[default]
    None,
}

/// Reads the file at `path`. The clip's name is the stem of the file.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read; the other variants if it is not a humanoid3d motion.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = crate::read::bytes(path)
        .map_err(|source| Error::Io { file: path.to_path_buf(), source })?;
    parse(&bytes, path)
}

/// Reads the text of a motion. `path` is used in errors, and its stem is the name of the clip.
///
/// # Errors
/// Those of [`read`], except [`Error::Io`].
pub fn parse(bytes: &[u8], path: &Path) -> Result<Recording, Error> {
    let file: File = serde_json::from_str(&encoding::lossy(bytes))
        .map_err(|source| Error::Json { file: path.to_path_buf(), source })?;
    let motion = motion(&file.frames);
    let (frame_time_s, frames) =
        motion.map_err(|problem| Error::Frames { file: path.to_path_buf(), problem })?;
    Ok(Recording {
        name: recording::stem(path),
        skeleton: skeleton::skeleton(),
        frames: frames.into_iter().map(|frame| frame.into_iter().map(Some).collect()).collect(),
        frame_time_s: Some(frame_time_s),
        metres_per_unit: Some(1.0),
        notes: Vec::new(),
    })
}

type Pose = Vec<JointSample>;

/// Returns the frame time, and the frames at even times.
fn motion(rows: &[Vec<f64>]) -> Result<(f64, Vec<Pose>), Problem> {
    if rows.len() < 2 {
        return Err(Problem::TooFew { frames: rows.len() });
    }
    let found = rows[0].len();
    if found != ROW && rows.iter().all(|row| row.len() == found) {
        return Err(Problem::OtherCharacter { expected: ROW, found });
    }
    let mut times_s = vec![0.0];
    let mut steps_s = Vec::with_capacity(rows.len());
    let mut poses = Vec::with_capacity(rows.len());
    for (frame, row) in rows.iter().enumerate() {
        poses.push(pose(frame, row)?);
        let step_s = row[0];
        if frame + 1 == rows.len() {
            break;
        }
        if !FRAME_TIME_S.contains(&step_s) {
            return Err(Problem::Time { frame, found: step_s });
        }
        steps_s.push(step_s);
        times_s.push(times_s[frame] + step_s);
    }
    let (shortest_s, longest_s) = steps_s
        .iter()
        .fold((f64::INFINITY, 0.0), |(low, high), &step_s| (step_s.min(low), step_s.max(high)));
    if longest_s <= shortest_s * (1.0 + TIME_ROUNDING) {
        let mean_s = times_s[rows.len() - 1] / (rows.len() - 1) as f64;
        return Ok((recording::snapped_s(mean_s), poses));
    }
    if longest_s > shortest_s * TIME_RATIO_MAX {
        return Err(Problem::Uneven { shortest_s, longest_s });
    }
    let frame_time_s = recording::snapped_s(shortest_s);
    Ok((frame_time_s, evenly(&times_s, &poses, frame_time_s)?))
}

/// Returns the motion at `0, frame_time_s, ..`, up to its end.
fn evenly(times_s: &[f64], poses: &[Pose], frame_time_s: f64) -> Result<Vec<Pose>, Problem> {
    let frames = (times_s[times_s.len() - 1] / frame_time_s).ceil() + 1.0;
    // A row is 44 numbers of at least two characters each.
    let limit = recording::sample_count_max(88 * poses.len()) / JOINTS.len();
    if frames > limit as f64 {
        return Err(Problem::TooMany { frames, frame_time_s, limit });
    }
    let mut even = Vec::new();
    let mut before = 0;
    let last = poses.len() - 1;
    loop {
        let time_s = even.len() as f64 * frame_time_s;
        while before < last && times_s[before + 1] <= time_s {
            before += 1;
        }
        if before == last {
            // The last row is included if it differs from an even time only by rounding.
            if time_s - times_s[last] < TIME_ROUNDING * frame_time_s {
                even.push(poses[last].clone());
            }
            return Ok(even);
        }
        let t = (time_s - times_s[before]) / (times_s[before + 1] - times_s[before]);
        let pair = poses[before].iter().zip(&poses[before + 1]);
        even.push(pair.map(|(a, b)| a.towards(b, t)).collect());
    }
}

/// Returns the pose that a row describes.
fn pose(frame: usize, row: &[f64]) -> Result<Pose, Problem> {
    if row.len() != ROW {
        return Err(Problem::RowLength { frame, expected: ROW, found: row.len() });
    }
    let refuse = |item, expected, found| Problem::Value { frame, item, expected, found };
    if let Some(&found) = row.iter().find(|value| value.abs() > MAGNITUDE_MAX) {
        return Err(refuse("row", "numbers of at most 1e9", found));
    }
    let mut at = 4;
    let mut samples = Vec::with_capacity(JOINTS.len());
    for joint in &JOINTS {
        let rotation = match joint.kind {
            Kind::Spherical => {
                let q = DQuat::from_xyzw(row[at + 1], row[at + 2], row[at + 3], row[at]);
                at += 4;
                if !NORM.contains(&q.length()) {
                    return Err(refuse(
                        joint.name,
                        "a unit quaternion (norm 0.5 to 1.5)",
                        q.length(),
                    ));
                }
                q.normalize()
            }
            Kind::Revolute => {
                at += 1;
                DQuat::from_rotation_z(row[at - 1])
            }
            Kind::Fixed => DQuat::IDENTITY,
        };
        let position_m = match joint.parent {
            None => DVec3::new(row[1], row[2], row[3]),
            Some(_) => joint.offset_m,
        };
        samples.push(JointSample { rotation, position_m });
    }
    Ok(samples)
}

#[cfg(test)]
mod tests;
