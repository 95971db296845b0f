//! Which joint of a rig follows which joint of a clip, as a text that a person reads and edits.
//!
//! The text is TOML: `[performance]` says how the clip is taken over, each `[[landmark]]` names joints of both sides,
//! and each `[[curve]]` takes one angle of a clip's joint to one joint of the rig. What is not listed is not taken: a
//! rig may follow a part of a clip. Angles are in degrees, lengths in metres.

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
    /// What the rig is called, for people.
    pub rig: String,
    /// What the clip is called, for people.
    pub clip: String,
    /// How the clip is taken over.
    pub performance: Performance,
    /// Places that rig and clip have in common.
    pub landmarks: Vec<Entry>,
    /// Angles that go straight to a joint.
    pub curves: Vec<Curve>,
}

/// How a clip is taken over.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Performance {
    /// How far the rig travels for a metre of the performer; `None`: by the length of the legs.
    pub scale: Option<f64>,
    /// Left and right changed.
    pub mirror: bool,
    /// Whether a free base travels.
    pub travels: bool,
    /// Of a rig whose base is fixed: how far the performance is tilted, rad.
    pub tilt_rad: f64,
    /// What comes first in arms with too few joints.
    pub arms: Limb,
    /// The same of legs.
    pub legs: Limb,
    /// Largest speed of turning joints that name none, rad/s.
    pub speed_rad_s: f64,
    /// Forward of the rig in the world, every joint at zero; `None`: by hips or shoulders.
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

/// One landmark on both sides.
#[derive(Debug, Clone, PartialEq)]
pub struct Entry {
    /// The place.
    pub landmark: Landmark,
    /// Name of the clip's joint, if it has one.
    pub clip: Option<String>,
    /// Names of the rig's joints, from the trunk outwards; of the chest those between it and the pelvis.
    pub rig: Vec<String>,
    /// The landmark's point on the rig, if it is not to be found from the axes.
    pub point: Option<Point>,
    /// From 0 to 1; written as a comment.
    pub confidence: f64,
    /// Why; written as a comment.
    pub reason: String,
}

/// A point of a rig's body.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Name of the body.
    pub body: String,
    /// Body frame, m.
    pub position_m: [f64; 3],
}

/// An angle of a clip's joint that goes to a joint of the rig.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Name of the clip's joint.
    pub clip: String,
    /// The axis about which its turn on its parent is measured.
    pub axis: [f64; 3],
    /// Name of the rig's joint, of one dof.
    pub rig: String,
    /// Angle of the clip in rad and position of the rig in rad or m; the first grow. Straight between, level beyond.
    pub points: Vec<[f64; 2]>,
    /// Whether the rig's joint slides.
    pub slides: bool,
}

/// What is wrong with a mapping.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MappingError {
    /// The text is no mapping.
    #[error("line {line}, column {column}: {message}")]
    Text {
        /// From 1.
        line: usize,
        /// In characters, from 1.
        column: usize,
        /// The key, what would be right, and what is there.
        message: String,
    },
    /// A value that does not fit the rig or the clip.
    #[error("{item}: expected {expected}, found {found}")]
    Value {
        /// The landmark or the curve, and the key.
        item: String,
        /// What would be right.
        expected: String,
        /// What is there.
        found: String,
    },
    /// The joints make no match.
    #[error(transparent)]
    RigMatchError(#[from] crate::rig::RigMatchError),
    /// All that is wrong.
    #[error("{} mistakes{}", .0.len(), lines(.0))]
    Several(Vec<Self>),
}

/// A line for each mistake.
fn lines(mistakes: &[MappingError]) -> String {
    mistakes.iter().fold(String::new(), |text, mistake| format!("{text}\n  {mistake}"))
}

/// What went well, or else all that is wrong.
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
