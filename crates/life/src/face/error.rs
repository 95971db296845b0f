//! Reasons why a file is not a face that a rig can show.

use thiserror::Error;

/// The reason why a file is not a face that a rig can show.
#[derive(Debug, Error)]
pub enum FaceError {
    /// The file is of another kind.
    #[error(
        "expected mouth cues of Rhubarb (JSON, TSV, .dat) or Papagayo (.dat), a CSV of Live Link Face, or a glTF with \
         shape keys; found {found}: {repair}"
    )]
    Kind {
        /// Kind of the file.
        found: String,
        /// Way to a file that can be read.
        repair: &'static str,
    },
    /// A value is invalid.
    #[error("{place}, {item}: expected {expected}, found `{found}`")]
    Value {
        /// Line of the file, or index of an entry.
        place: String,
        /// The item of this line.
        item: String,
        /// Description of a valid value.
        expected: String,
        /// Text that was found.
        found: String,
    },
    /// The text is not JSON of mouth cues.
    #[error(
        "line {line}, column {column}: {message}; expected `{{ \"mouthCues\": [ {{ \"start\": 0.00, \"end\": 0.27, \
         \"value\": \"X\" }}, .. ] }}`"
    )]
    Json {
        /// Line of the file.
        line: usize,
        /// Column of the line.
        column: usize,
        /// Message of the parser.
        message: String,
    },
    /// The text is not CSV.
    #[error(transparent)]
    Csv(#[from] csv::Error),
    /// The file has too few rows or cues.
    #[error("expected at least {expected}, found {found}")]
    Few {
        /// Description of a sufficient number.
        expected: &'static str,
        /// Number that was found.
        found: usize,
    },
    /// The face is too long.
    #[error("the face lasts {0:.1} s: expected 7200 s at most")]
    TooLong(f64),
    /// The rig has no shapes.
    #[error(
        "the rig has no `[[shape]]`: its rig.toml must say where joints are in each shape, such as `[[shape]]` with \
         `name = \"{example}\"` and `pose = {{ jaw = -20 }}` (deg); `sinew rig new --face` writes all names"
    )]
    NoShapes {
        /// A name that the file needs.
        example: String,
    },
    /// No shape of the file moves a joint.
    #[error(
        "no shape of the file moves a joint of the rig. The file has {file}; shapes of the rig with a pose are {rig}"
    )]
    NothingMoves {
        /// Names in the file.
        file: String,
        /// Names in the rig.
        rig: String,
    },
    /// The rig lacks the viseme of a cue.
    #[error(
        "{place}: the rig has no shape `{viseme}` for the mouth `{cue}`: expected `[[shape]]` with `name = \
         \"{viseme}\"` (or `name = \"{cue}\"`) and a pose, or `pose = {{}}`"
    )]
    NoViseme {
        /// Line of the file, or index of an entry.
        place: String,
        /// Name of the viseme.
        viseme: &'static str,
        /// Name in the file.
        cue: String,
    },
    /// A joint is far too slow.
    #[error(
        "joint `{joint}` is too slow for this face: its speed and acceleration leave {percent:.1} % of the way"
    )]
    TooSlow {
        /// Name of the joint.
        joint: String,
        /// Share of the way, in percent.
        percent: f64,
    },
}
