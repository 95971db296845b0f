//! Mapping files (TOML).

use std::path::{Path, PathBuf};

use serde::Deserialize;
use sinew_host_util::parse_message;
use sinew_mocap::skeleton_map::{BodyJoints, Signature};
use sinew_mocap::{Kind, Recording, SkeletonMap, Up, read};

use crate::{BODIES, BODY_COUNT};

/// A skeleton that cannot be mapped, or a mapping file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file system refused.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// The file.
        file: PathBuf,
        /// What the system says.
        source: std::io::Error,
    },
    /// Not a mapping file.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// The file.
        file: PathBuf,
        /// Line, column and what was expected.
        source: Box<toml::de::Error>,
    },
    /// Neither a file nor a name.
    #[error(
        "{}: no such file, and no known skeleton of that name: expected a file or one of {known}", path.display()
    )]
    NoSuchMapping {
        /// What was asked for.
        path: PathBuf,
        /// Names of the known ones.
        known: String,
    },
    /// The skeleton is unknown.
    #[error(
        "no known skeleton has the joints {found} (tried: {tried}).{nearest} Write a mapping after what \
         `sinew clip map` prints, and give it with --mapping"
    )]
    NoneMatches {
        /// The skeleton's joints.
        found: String,
        /// Names of the mappings.
        tried: String,
        /// A sentence on the nearest one, or nothing.
        nearest: String,
    },
    /// The skeleton is unknown, and no mapping can be proposed.
    #[error("{unknown}\nNone is proposed: {why}")]
    NotProposed {
        /// That no known one is for it.
        unknown: Box<Error>,
        /// Why not.
        why: String,
    },
    /// Two mappings claim the same skeleton.
    #[error("the skeleton fits several mappings ({names}); give one of them with --mapping")]
    SeveralMatch {
        /// Names of the mappings.
        names: String,
    },
    /// The mapping is for another skeleton.
    #[error("mapping `{mapping}`{}", told(mistakes, found))]
    Wrong {
        /// Name of the mapping.
        mapping: String,
        /// All that is wrong.
        mistakes: Vec<Mistake>,
        /// The skeleton's joints.
        found: String,
    },
}

/// Neither the file nor its mapping tells the frame rate.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the file does not tell its frame rate, and neither does mapping `{mapping}`: expected \
     `rate_hz = 120` or the like in the mapping"
)]
pub struct NoRate {
    /// Name of the mapping.
    pub mapping: String,
}

/// What of a mapping does not fit a skeleton.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Mistake {
    /// A joint is missing.
    #[error("body `{body}` needs joint `{joint}`")]
    NoSuchJoint {
        /// Name of the body.
        body: &'static str,
        /// The joint.
        joint: String,
    },
    /// A body would not move with its parent.
    #[error(
        "body `{body}`, {key}: expected a joint that moves with `{parent_joint}`, whose frame its parent `{parent}` has; \
         found `{joint}`, which does not"
    )]
    BrokenTree {
        /// Name of the body.
        body: &'static str,
        /// `origin` or `rotation`.
        key: &'static str,
        /// The joint it names.
        joint: String,
        /// The body's parent.
        parent: &'static str,
        /// The joint whose frame the parent has.
        parent_joint: String,
    },
    /// The joint goes on in other joints, or just ends.
    #[error("the end of body `{body}` needs an end site on joint `{joint}`")]
    NoEndSite {
        /// Name of the body.
        body: &'static str,
        /// The joint without one.
        joint: String,
    },
}

/// All mistakes, each in a line if there are several; and the skeleton's joints where one is missing.
fn told(mistakes: &[Mistake], found: &str) -> String {
    let mut text = match mistakes {
        [one] => format!(": {one}"),
        _ => mistakes.iter().fold(format!(": {} mistakes", mistakes.len()), |text, mistake| {
            format!("{text}\n  {mistake}")
        }),
    };
    if mistakes.iter().any(|mistake| matches!(mistake, Mistake::NoSuchJoint { .. })) {
        let joined = if mistakes.len() == 1 { ", but the clip has" } else { "\n  The clip has" };
        text = format!("{text}{joined} {found}");
    }
    text
}

/// How a recorded skeleton makes the figure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "SkeletonMap")]
pub struct Mapping {
    /// Name for messages.
    pub name: String,
    /// Length of the file's unit, in metres, for files that do not tell it.
    pub metres_per_unit: f64,
    /// Frames per second, for files that do not tell them.
    pub rate_hz: Option<f64>,
    /// The axis of the files that points up; `None` to see it in the motion.
    pub up: Option<Up>,
    /// How the skeleton is known.
    pub signature: Signature,
    /// What makes each body, in the figure's order.
    pub parts: Vec<BodyJoints>,
}

impl Mapping {
    /// Reads a mapping from TOML text.
    ///
    /// # Errors
    /// A message with line and column if the text is not a mapping of all 18 bodies.
    pub fn parse(text: &str) -> Result<Self, toml::de::Error> {
        toml::from_str(text)
    }

    /// Reads the mapping file at `path`.
    ///
    /// # Errors
    /// [`Error::Io`] or [`Error::Toml`], with the file's name.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let file = || path.to_path_buf();
        let expected =
            "a mapping on the human figure (without --rig), as `sinew clip map` proposes it";
        let text = read::text_of(path, expected, &[Kind::FigureMapping, Kind::Toml])
            .map_err(|source| Error::Io { file: file(), source })?;
        Self::parse(&text).map_err(|source| Error::Toml { file: file(), source: Box::new(source) })
    }

    /// Time between the frames of a recording, in seconds: its own, or else the mapping's.
    ///
    /// # Errors
    /// [`NoRate`] if nobody tells the rate.
    pub fn frame_time_s(&self, recording: &Recording) -> Result<f64, NoRate> {
        let told_s = recording.frame_time_s.or(self.rate_hz.map(f64::recip));
        told_s.ok_or_else(|| NoRate { mapping: self.name.clone() })
    }
}

impl TryFrom<SkeletonMap> for Mapping {
    type Error = String;

    fn try_from(map: SkeletonMap) -> Result<Self, String> {
        let SkeletonMap { name, metres_per_unit, rate_hz, up, signature, mut bodies } = map;
        let mut parts = Vec::with_capacity(BODY_COUNT);
        let mut missing = Vec::new();
        for place in &BODIES {
            match bodies.remove(place.name) {
                Some(part) => parts.push(part),
                None => missing.push(place.name),
            }
        }
        let list = |names: &[&str]| format!("`{}`", names.join("`, `"));
        let mut wrong = Vec::new();
        if !missing.is_empty() {
            let (names, are) = (list(&missing), if missing.len() == 1 { "is" } else { "are" });
            wrong.push(format!("expected {names}, which {are} missing"));
        }
        if !bodies.is_empty() {
            let strangers: Vec<&str> = bodies.keys().map(String::as_str).collect();
            let names = BODIES.map(|place| place.name).join(", ");
            wrong.push(format!("expected only {names}; found {}", list(&strangers)));
        }
        if !wrong.is_empty() {
            return Err(format!("[body]: {}", wrong.join("; ")));
        }
        Ok(Self { name, metres_per_unit, rate_hz, up, signature, parts })
    }
}
