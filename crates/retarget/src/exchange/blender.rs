//! Positions of servos as the Blender servo animation add-on writes them: JSON of `fps`, `frames` and `positions`, a
//! table of servo number and position for each frame. Its later versions have `servos` instead, with all positions of
//! each.
//!
//! What the numbers mean is up to the builder; here they are steps of a bus servo's encoder, and pulses in us of a
//! hobby servo.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sinew_rig::description::Description;
use thiserror::Error;

use super::servos::{ServoTrack, ServoTrackError, number_of};

/// The most frames of a file: an hour at 240 Hz, four times over.
const FRAMES_MAX: usize = 4_000_000;

/// Why a file is none of the add-on's.
#[derive(Debug, Error)]
pub enum BlenderError {
    /// It is no such JSON.
    #[error("expected the JSON of the Blender servo animation add-on: {0}")]
    Json(#[from] serde_json::Error),
    /// A rate that is none.
    #[error("fps: expected a number of frames a second from 1 to 1000, found {0}")]
    Rate(f64),
    /// Neither kind of table, or too little of it.
    #[error("expected `positions` of at least 2 frames, or `servos`; found {0} frames")]
    Frames(usize),
    /// The table and the rig do not fit.
    #[error(transparent)]
    Servos(#[from] ServoTrackError),
}

#[derive(Debug, Serialize, Deserialize)]
struct File {
    #[serde(default)]
    description: String,
    fps: f64,
    #[serde(default)]
    frames: usize,
    #[serde(default)]
    seconds: f64,
    #[serde(default)]
    bones: usize,
    #[serde(default)]
    armature: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    positions: Option<Vec<BTreeMap<u8, i32>>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    servos: Option<BTreeMap<u8, OfServo>>,
}

#[derive(Debug, Serialize, Deserialize)]
struct OfServo {
    #[serde(default)]
    name: String,
    positions: Vec<i32>,
}

/// The JSON of a rig's servos: every servo in every frame.
///
/// # Errors
/// [`BlenderError`] if there are no frames.
pub fn write(rig: &str, tracks: &[ServoTrack], fps: f64) -> Result<String, BlenderError> {
    let frames = tracks.iter().map(|track| track.positions.len()).max().unwrap_or(0);
    if frames == 0 {
        return Err(BlenderError::Frames(0));
    }
    let of_frame = |frame: usize| {
        tracks
            .iter()
            .filter_map(|track| Some((number_of(track.address), *track.positions.get(frame)?)))
            .collect()
    };
    let file = File {
        description: "Servo positions, written by Sinew".to_owned(),
        fps,
        frames,
        seconds: frames as f64 / fps,
        bones: tracks.len(),
        armature: rig.to_owned(),
        positions: Some((0..frames).map(of_frame).collect()),
        servos: None,
    };
    Ok(serde_json::to_string_pretty(&file)?)
}

/// Reads positions of a rig's servos, and the frames a second. A servo that a frame does not name stays where it was.
///
/// # Errors
/// [`BlenderError`] names what is wrong, and what would be right.
pub fn read(text: &str, rig: &Description) -> Result<(Vec<ServoTrack>, f64), BlenderError> {
    let file: File = serde_json::from_str(text)?;
    // Written so that NaN is refused.
    if !(1.0..=1000.0).contains(&file.fps) {
        return Err(BlenderError::Rate(file.fps));
    }
    let mut by_number: BTreeMap<u8, Vec<i32>> = BTreeMap::new();
    match (file.positions, file.servos) {
        (Some(frames), _) if (2..=FRAMES_MAX).contains(&frames.len()) => {
            for (frame, positions) in frames.iter().enumerate() {
                for (number, position) in positions {
                    let track = by_number.entry(*number).or_default();
                    // Nothing was said of it so far: it stands where it is first told to be.
                    track.resize(frame, track.last().copied().unwrap_or(*position));
                    track.push(*position);
                }
            }
            for track in by_number.values_mut() {
                track.resize(frames.len(), track.last().copied().unwrap_or(0));
            }
        }
        (None, Some(servos)) if servos.values().all(|servo| servo.positions.len() >= 2) => {
            by_number.extend(servos.into_iter().map(|(number, servo)| (number, servo.positions)));
        }
        (positions, _) => return Err(BlenderError::Frames(positions.map_or(0, |all| all.len()))),
    }
    let tracks = by_number
        .into_iter()
        .map(|(number, positions)| {
            let servo = rig.servos.iter().find(|servo| number_of(servo.address) == number);
            let servo = servo.ok_or_else(|| ServoTrackError::UnknownServo {
                found: number.to_string(),
                expected: rig
                    .servos
                    .iter()
                    .map(|servo| number_of(servo.address).to_string())
                    .collect::<Vec<_>>()
                    .join(", "),
            })?;
            Ok(ServoTrack {
                servo: servo.name.clone(),
                address: servo.address,
                positions,
                limited: 0,
            })
        })
        .collect::<Result<_, ServoTrackError>>()?;
    Ok((tracks, file.fps))
}
