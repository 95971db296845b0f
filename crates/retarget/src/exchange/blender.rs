//! Servo positions in the format of the Blender servo animation add-on: JSON with `fps`, `frames` and `positions`: for
//! each frame, a table from servo number to position. Later versions of the add-on have `servos` instead: for each
//! servo, a list of its positions.
//!
//! The rig's builder chooses the unit of the numbers; this module uses encoder steps for a bus servo, and pulses in us
//! for a hobby servo.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use sinew_rig::description::Description;
use sinew_rig::servo::Address;
use thiserror::Error;

use super::servos::{ServoTrack, ServoTrackError, check_pulses, number_of};

/// Maximum number of frames of a file: 4.6 hours at 240 Hz.
const FRAMES_MAX: usize = 4_000_000;

/// The reason why a file of the add-on is invalid.
#[derive(Debug, Error)]
pub enum BlenderError {
    /// The file is not JSON of this form.
    #[error("expected the JSON of the Blender servo animation add-on: {0}")]
    Json(#[from] serde_json::Error),
    /// The frame rate is invalid.
    #[error("fps: expected a number of frames a second from 1 to 1000, found {0}")]
    Rate(f64),
    /// The file has neither `positions` nor `servos`, or the number of frames is below 2 or too large.
    #[error("expected `positions` of at least 2 frames, or `servos`; found {0} frames")]
    Frames(usize),
    /// The table does not fit the rig.
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

/// Returns the JSON of a rig's servos, with every servo in every frame.
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

/// Reads positions of a rig's servos, and the frame rate. A servo that a frame does not contain keeps its position.
///
/// # Errors
/// [`BlenderError`] describes the error and a valid value.
pub fn read(text: &str, rig: &Description) -> Result<(Vec<ServoTrack>, f64), BlenderError> {
    let file: File = serde_json::from_str(text)?;
    // The comparison also refuses NaN.
    if !(1.0..=1000.0).contains(&file.fps) {
        return Err(BlenderError::Rate(file.fps));
    }
    let mut by_number: BTreeMap<u8, Vec<i32>> = BTreeMap::new();
    match (file.positions, file.servos) {
        (Some(frames), _) if (2..=FRAMES_MAX).contains(&frames.len()) => {
            for (frame, positions) in frames.iter().enumerate() {
                for (number, position) in positions {
                    let track = by_number.entry(*number).or_default();
                    // Before its first entry, the servo has the position of that entry.
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
            if matches!(servo.address, Address::Channel(_)) {
                check_pulses(&servo.name, &positions)?;
            }
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
