//! Mouth cues in the TSV of Rhubarb. Each line contains a time in s, a tab, and a mouth shape.

use super::error::FaceError;
use super::track::{Cue, FaceTrack};

/// Returns whether a line consists of a time and a mouth shape.
pub(super) fn is_cue(line: &str) -> bool {
    parse(line).is_some()
}

fn parse(line: &str) -> Option<(f64, &str)> {
    let (time, mouth) = line.split_once(['\t', ' '])?;
    let time_s = time.parse().ok().filter(|time| (0.0..1e6).contains(time))?;
    let mouth = mouth.trim();
    let is_word = mouth.len() <= 12 && mouth.chars().all(|letter| letter.is_ascii_alphabetic());
    (is_word && !mouth.is_empty()).then_some((time_s, mouth))
}

/// Reads all cues of the file.
pub(super) fn read(text: &str) -> Result<FaceTrack, FaceError> {
    let mut cues = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() {
            continue;
        }
        let place = format!("line {}", index + 1);
        let Some((start_s, mouth)) = parse(line) else {
            return Err(FaceError::Value {
                place,
                item: "the mouth cue".to_owned(),
                expected: "a time in s, a tab, and a mouth shape, such as `0.27\tA`".to_owned(),
                found: line.chars().take(40).collect(),
            });
        };
        cues.push(Cue { start_s, mouth: mouth.to_owned(), place });
    }
    FaceTrack::of_cues(cues, 0.0)
}
