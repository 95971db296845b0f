//! Mouth cues as a Moho switch, which Papagayo and Rhubarb write. The first line is `MohoSwitch1`; each other line
//! contains a frame number, from 1, and a mouth shape.

use super::error::FaceError;
use super::track::{Cue, FaceTrack};

/// First line of the file.
pub(super) const HEAD: &str = "MohoSwitch1";
/// Default frames per second, as in Papagayo and Rhubarb.
const FPS: f64 = 24.0;

/// Reads all cues of the file.
pub(super) fn read(text: &str, fps: Option<f64>) -> Result<FaceTrack, FaceError> {
    let fps = fps.unwrap_or(FPS);
    let mut cues = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line == HEAD {
            continue;
        }
        let place = format!("line {}", index + 1);
        let frame_of = |text: &str| text.parse::<u32>().ok().filter(|frame| *frame >= 1);
        let mut words = line.split_whitespace();
        let frame = words.next().and_then(frame_of);
        let mouth = words.next();
        let (Some(frame), Some(mouth), None) = (frame, mouth, words.next()) else {
            return Err(FaceError::Value {
                place,
                item: "the mouth cue".to_owned(),
                expected: "a frame from 1 on, a space, and a mouth shape, such as `12 MBP`"
                    .to_owned(),
                found: line.chars().take(40).collect(),
            });
        };
        cues.push(Cue { start_s: f64::from(frame - 1) / fps, mouth: mouth.to_owned(), place });
    }
    FaceTrack::of_cues(cues, 0.0)
}
