//! Recognizes the kind of a face file by its content.

use super::error::FaceError;
use super::track::FaceTrack;
use super::{json, live_link, moho, tsv};

/// First characters of files of other kinds, the name of the kind, and the way to a file that can be read.
const OTHERS: [(&str, &str, &str); 9] = [
    (
        "RIFF",
        "a sound",
        "`sinew clip jaw` moves a jaw by a sound; Rhubarb makes mouth cues from it",
    ),
    ("glTF", "a binary glTF", "name it *.glb"),
    ("Kaydara FBX", "an FBX", "open it in Blender, and export glTF with animated shape keys"),
    ("; FBX", "an FBX", "open it in Blender, and export glTF with animated shape keys"),
    ("lipsync version", "a project of Papagayo", "export the voice as a Moho switch: *.dat"),
    ("HIERARCHY", "a BVH clip", "`sinew bake` reads it as it is"),
    ("PK\u{3}\u{4}", "a zip archive", "unpack it first, and give the CSV in it"),
    ("<?xml", "XML", "`rhubarb -f json` or `-f tsv` writes mouth cues that can be read"),
    ("<", "XML", "`rhubarb -f json` or `-f tsv` writes mouth cues that can be read"),
];

/// Reads a face. `fps`: frames per second of a file that counts frames. Default: 24 for `.dat`; for Live Link Face, the
/// lowest usual rate that its frame numbers permit.
///
/// # Errors
/// [`FaceError`] contains the line, the item, and the valid form.
pub fn read(bytes: &[u8], fps: Option<f64>) -> Result<FaceTrack, FaceError> {
    let text = String::from_utf8_lossy(bytes);
    let text = text.trim_start_matches('\u{feff}');
    let first = text.trim_start();
    if let Some((_, found, repair)) = OTHERS.iter().find(|(start, ..)| first.starts_with(start)) {
        return Err(FaceError::Kind { found: (*found).to_owned(), repair });
    }
    let line = first.lines().next().unwrap_or_default().trim();
    if line == moho::HEAD {
        return moho::read(text, fps);
    }
    if first.starts_with(['{', '[']) {
        return json::read(text);
    }
    let lower = line.to_lowercase();
    if lower.contains("timecode") && lower.contains(',') {
        return live_link::read(text, fps);
    }
    if tsv::is_cue(line) {
        return tsv::read(text);
    }
    let (found, repair) = if text.trim().is_empty() {
        ("an empty file", "export it again")
    } else if lower.starts_with("mohoswitch") {
        ("a Moho switch of another version", "its first line must be `MohoSwitch1`")
    } else if lower.starts_with("time") && lower.contains(['_', ',', ';']) {
        ("a table of keys of joints", "`sinew bake` reads it as it is")
    } else if lower.contains("blendshape") || lower.contains("jawopen") {
        (
            "a table of blend shapes without time code",
            "its header must be that of Live Link Face: `Timecode,BlendShapeCount,EyeBlinkLeft, ..`",
        )
    } else {
        ("something else", "see docs/face.md for the form of each file")
    };
    Err(FaceError::Kind { found: found.to_owned(), repair })
}
