//! The text motions of `DeepMimic` (X. B. Peng et al., 2018): `humanoid3d_*.txt`.
//!
//! A JSON object with `Loop` ("wrap" or "none") and `Frames`: rows of 44 numbers, which are the time to
//! the next frame (s), the root's position (m) and rotation, and the rotations of the joints in the
//! order of [`skeleton`]. Spherical joints have a quaternion `w x y z`, knees and elbows an angle
//! about z (rad). y is up, x ahead, z to the right.
//!
//! The motion is read once through, whether or not it is said to wrap. The last row's time belongs to
//! no step and is not used. Where the times differ, the motion is brought to the shortest of them:
//! rotations along the great arc, positions along the line.

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

/// Numbers in a row.
const ROW: usize = 44;
/// Hand-edited frames hold blends of quaternions, down to 0.58 in `humanoid3d_kick.txt`; these are
/// normalized, as `DeepMimic` does. A norm beyond is no rotation.
const NORM: std::ops::RangeInclusive<f64> = 0.5..=1.5;
/// Times that differ by less, as a ratio, are one time in different rounding.
const TIME_ROUNDING: f64 = 1e-3;
/// Largest ratio of two times: what bounds the frames that a small file can ask for.
const TIME_RATIO_MAX: f64 = 100.0;

#[derive(Deserialize)]
struct File {
    #[serde(rename = "Loop", default)]
    _loop: Loop,
    #[serde(rename = "Frames")]
    frames: Vec<Vec<f64>>,
}

/// Not in the files of all that use the format.
#[derive(Default, Deserialize)]
#[serde(rename_all = "lowercase")]
enum Loop {
    Wrap,
    #[default]
    None,
}

/// Reads the file at `path`; the clip is named after its stem.
///
/// # Errors
/// [`Error::Io`] if the file cannot be read, the others if it is not a humanoid3d motion.
pub fn read(path: &Path) -> Result<Recording, Error> {
    let bytes = crate::read::bytes(path)
        .map_err(|source| Error::Io { file: path.to_path_buf(), source })?;
    parse(&bytes, path)
}

/// Reads the text of a motion; `path` names it in errors and its stem names the clip.
///
/// # Errors
/// As [`read`].
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

/// Frame time and frames, evenly spaced.
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

/// The motion at `0, frame_time_s, ..`, up to its end.
fn evenly(times_s: &[f64], poses: &[Pose], frame_time_s: f64) -> Result<Vec<Pose>, Problem> {
    let frames = (times_s[times_s.len() - 1] / frame_time_s).ceil() + 1.0;
    // A row is 44 numbers of two characters at least.
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
            // A last frame that falls on the grid but for rounding belongs to it.
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

/// The pose that a row describes.
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
