//! Mouth cues in the JSON of Rhubarb.

use serde::Deserialize;
use serde_json::error::Category;

use super::error::FaceError;
use super::track::{Cue, FaceTrack};

/// Content of the file. Other keys are ignored.
#[derive(Debug, Deserialize)]
struct File {
    #[serde(rename = "mouthCues")]
    mouth_cues: Vec<MouthCue>,
}

#[derive(Debug, Deserialize)]
struct MouthCue {
    start: f64,
    end: f64,
    value: String,
}

/// Reads `{ "metadata": .., "mouthCues": [ { "start": 0.00, "end": 0.05, "value": "X" }, .. ] }`.
pub(super) fn read(text: &str) -> Result<FaceTrack, FaceError> {
    let file: File = serde_json::from_str(text).map_err(|error| {
        if error.classify() == Category::Data && !text.contains("mouthCues") {
            return FaceError::Kind {
                found: "JSON without `mouthCues`".to_owned(),
                repair: "`rhubarb -f json` writes mouth cues",
            };
        }
        FaceError::Json { line: error.line(), column: error.column(), message: error.to_string() }
    })?;
    let mut cues = Vec::new();
    for (index, cue) in file.mouth_cues.iter().enumerate() {
        let MouthCue { start, end, value } = cue;
        // The comparison also refuses NaN.
        if !(*start >= 0.0 && end >= start && *end < 1e6) {
            return Err(FaceError::Value {
                place: format!("mouthCues[{index}]"),
                item: "`end`".to_owned(),
                expected: format!("a time from {start} s on, and `start` from 0 on"),
                found: format!("{end}"),
            });
        }
        let place = format!("mouthCues[{index}]");
        cues.push(Cue { start_s: *start, mouth: value.trim().to_owned(), place });
    }
    FaceTrack::of_cues(cues, file.mouth_cues.last().map_or(0.0, |cue| cue.end))
}
