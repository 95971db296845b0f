//! Reasons why a rig cannot show the face in a file.

use thiserror::Error;

/// Reason why a rig cannot show the face in a file.
#[derive(Debug, Error)]
pub enum FaceError {
    /// The file contains something else.
    #[error(
        "expected mouth cues of Rhubarb (JSON, TSV, .dat) or Papagayo (.dat), a CSV of Live Link Face, or a glTF with \
         shape keys; found {found}: {repair}"
    )]
    Kind {
        /// Kind of content that was found.
        found: String,
        /// Way to get a file that can be read.
        repair: &'static str,
    },
    /// A value is invalid.
    #[error("{place}, {item}: expected {expected}, found `{found}`")]
    Value {
        /// Line of the file, or index of an entry.
        place: String,
        /// Name of the item in this line.
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
        /// Name of a shape in the file.
        example: String,
    },
    /// No shape of the file moves a joint of the rig.
    #[error(
        "no shape of the file moves a joint of the rig. The file has {file}; shapes of the rig with a pose are {rig}"
    )]
    NothingMoves {
        /// Names of the shapes in the file.
        file: String,
        /// Names of the rig's shapes with a pose.
        rig: String,
    },
    /// The rig lacks the viseme that a cue needs.
    #[error(
        "{place}: the rig has no shape `{viseme}` for the mouth `{cue}`: expected `[[shape]]` with `name = \
         \"{viseme}\"` (or `name = \"{cue}\"`) and a pose, or `pose = {{}}`"
    )]
    NoViseme {
        /// Line of the file, or index of an entry.
        place: String,
        /// Name of the viseme.
        viseme: &'static str,
        /// Name of the mouth shape in the file.
        cue: String,
    },
    /// A joint is too slow to keep a visible motion.
    #[error(
        "joint `{joint}` is too slow for this face: its speed and acceleration leave {percent:.1} % of the way"
    )]
    TooSlow {
        /// Name of the joint.
        joint: String,
        /// Share of the motion that its limits permit, in percent.
        percent: f64,
    },
}
