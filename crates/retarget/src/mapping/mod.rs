//! A map from joints of a clip to joints of a rig, as a text that a person reads and edits.
//!
//! The text is TOML: `[performance]` contains settings, each `[[landmark]]` names joints of the clip and of the rig,
//! and each `[[curve]]` drives one joint of the rig by one angle of a clip's joint. Landmarks that are not listed are
//! not used, so a rig may follow only a part of a clip. Angles are in degrees, lengths in metres.

mod curve;
mod propose;
mod read;
mod resolve;
mod write;

use crate::Landmark;
use crate::solve::Limb;

pub use curve::{Curves, Follower};

/// A mapping, by names.
#[derive(Debug, Clone, PartialEq)]
pub struct Mapping {
    /// Name of the rig, for readers.
    pub rig: String,
    /// Name of the clip, for readers.
    pub clip: String,
    /// Settings of the performance.
    pub performance: Performance,
    /// Landmarks of the rig, of the clip, or of both.
    pub landmarks: Vec<Entry>,
    /// Angles that directly drive a joint.
    pub curves: Vec<Curve>,
}

/// Settings by which a rig follows a clip.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Performance {
    /// Distance that the rig travels per metre of the performer; `None`: the ratio of leg lengths.
    pub scale: Option<f64>,
    /// Whether left and right are exchanged.
    pub mirror: bool,
    /// Whether a rig with a free base travels with the performer.
    pub travels: bool,
    /// For a rig with a fixed base: angle by which the performance is tilted, rad.
    pub tilt_rad: f64,
    /// Priority in arms with too few joints.
    pub arms: Limb,
    /// Priority in legs with too few joints.
    pub legs: Limb,
    /// Maximum speed of joints without a speed limit, rad/s.
    pub speed_rad_s: f64,
    /// Forward direction of the rig in the world, with every joint at zero; `None`: derived from hips or shoulders.
    pub forward: Option<[f64; 3]>,
}

impl Default for Performance {
    fn default() -> Self {
        let settings = crate::solve::Settings::default();
        Self {
            scale: settings.scale,
            mirror: settings.is_mirrored,
            travels: settings.travels,
            tilt_rad: settings.tilt_rad,
            arms: settings.arms,
            legs: settings.legs,
            speed_rad_s: settings.speed_rad_s,
            forward: None,
        }
    }
}

/// A landmark with its joints in the clip and in the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The landmark.
    pub landmark: Landmark,
    /// Name of the clip's joint, if the clip has the landmark.
    pub clip: Option<String>,
    /// Names of the rig's joints, from the trunk outwards; for the chest, the joints between chest and pelvis.
    pub rig: Vec<String>,
    /// Point of the landmark on the rig, if it does not follow from the axes.
    pub point: Option<Point>,
    /// Confidence from 0 to 1; written as a comment.
    pub confidence: f64,
    /// Reason for the confidence; written as a comment.
    pub reason: String,
}

/// A point of a rig's body.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of the body.
    pub body: String,
    /// Position in the body frame, m.
    pub position_m: [f64; 3],
}

/// A curve that drives a joint of the rig by an angle of a clip's joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name of the clip's joint.
    pub clip: String,
    /// Axis about which the joint's rotation relative to its parent is measured.
    pub axis: [f64; 3],
    /// Name of the rig's joint, of one dof.
    pub rig: String,
    /// Pairs of the clip's angle (rad, rising) and the rig's position (rad or m). Linear between points, constant
    /// beyond.
    pub points: Vec<[f64; 2]>,
    /// Whether the rig's joint slides.
    pub slides: bool,
}

/// The reason why a mapping is invalid.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MappingError {
    /// The text is not a valid mapping.
    #[error("line {line}, column {column}: {message}")]
    Text {
        /// Line of the error, from 1.
        line: usize,
        /// Column of the error in characters, from 1.
        column: usize,
        /// Key, description of a valid value, and value that was found.
        message: String,
    },
    /// A value does not fit the rig or the clip.
    #[error("{item}: expected {expected}, found {found}")]
    Value {
        /// Landmark or curve, and the key.
        item: String,
        /// Description of a valid value.
        expected: String,
        /// Value that was found.
        found: String,
    },
    /// The joints do not match the rig.
    #[error(transparent)]
    RigMatchError(#[from] crate::rig::RigMatchError),
    /// Several errors, all listed.
    #[error("{} mistakes{}", .0.len(), lines(.0))]
    Several(Vec<Self>),
}

/// Returns a line for each error.
fn lines(mistakes: &[MappingError]) -> String {
    mistakes.iter().fold(String::new(), |text, mistake| format!("{text}\n  {mistake}"))
}

/// Collects all results, or all errors.
fn all<T>(
    results: impl IntoIterator<Item = Result<T, MappingError>>,
) -> Result<Vec<T>, MappingError> {
    let (mut good, mut mistakes) = (Vec::new(), Vec::new());
    for result in results {
        match result {
            Ok(one) => good.push(one),
            Err(MappingError::Several(several)) => mistakes.extend(several),
            Err(mistake) => mistakes.push(mistake),
        }
    }
    match mistakes.len() {
        0 => Ok(good),
        1 => Err(mistakes.remove(0)),
        _ => Err(MappingError::Several(mistakes)),
    }
}

impl MappingError {
    fn value(
        item: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Value { item: item.into(), expected: expected.into(), found: found.into() }
    }
}
