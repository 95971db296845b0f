//! Mapping files (TOML).

use std::path::{Path, PathBuf};

use serde::Deserialize;
use sinew_host_util::parse_message;
use sinew_mocap::skeleton_map::{BodyJoints, Signature};
use sinew_mocap::{Kind, Recording, SkeletonMap, Up, read};

use crate::{BODIES, BODY_COUNT};

/// The error of a skeleton that cannot be mapped, or of a mapping file that cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// A file that could not be read.
    #[error("{}: cannot be read: {source}", file.display())]
    Io {
        /// Path of the file.
        file: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file that is not a mapping file.
    #[error("{}: {}", file.display(), parse_message(source))]
    Toml {
        /// Path of the file.
        file: PathBuf,
        /// Line, column and expectation, from the TOML parser.
        source: Box<toml::de::Error>,
    },
    /// A path that is neither a file nor the name of a known skeleton.
    #[error(
        "{}: no such file, and no known skeleton of that name: expected a file or one of {known}", path.display()
    )]
    NoSuchMapping {
        /// The requested file or name.
        path: PathBuf,
        /// Names of the known skeletons.
        known: String,
    },
    /// A skeleton that matches no known mapping.
    #[error(
        "no known skeleton has the joints {found} (tried: {tried}).{nearest} Write a mapping, starting from the output \
         of `sinew clip map`, and give it with --mapping"
    )]
    NoneMatches {
        /// Joints of the skeleton.
        found: String,
        /// Names of the mappings that were tried.
        tried: String,
        /// A sentence about the nearest mapping; empty if none is near.
        nearest: String,
    },
    /// An unknown skeleton for which no mapping can be proposed.
    #[error("{unknown}\nNone is proposed: {why}")]
    NotProposed {
        /// The error that no known mapping matches.
        unknown: Box<Error>,
        /// Reason why no mapping is proposed.
        why: String,
    },
    /// A skeleton that matches several mappings.
    #[error("the skeleton fits several mappings ({names}); give one of them with --mapping")]
    SeveralMatch {
        /// Names of the matching mappings.
        names: String,
    },
    /// A mapping that does not fit the skeleton.
    #[error("mapping `{mapping}`{}", told(mistakes, found))]
    Wrong {
        /// Name of the mapping.
        mapping: String,
        /// Everything in the mapping that does not fit.
        mistakes: Vec<Mistake>,
        /// Joints of the skeleton.
        found: String,
    },
}

/// The error of a recording whose frame rate is neither in the file nor in its mapping.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "the file does not state its frame rate, nor does mapping `{mapping}`: expected a line such as `rate_hz = 120` in \
     the mapping"
)]
pub struct NoRate {
    /// Name of the mapping.
    pub mapping: String,
}

/// A part of a mapping that does not fit a skeleton.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Mistake {
    /// A joint that the skeleton lacks.
    #[error("body `{body}` needs joint `{joint}`")]
    NoSuchJoint {
        /// Name of the body.
        body: &'static str,
        /// Name of the missing joint.
        joint: String,
    },
    /// A body that would not move with its parent.
    #[error(
        "body `{body}`, {key}: expected a joint that moves with `{parent_joint}`, whose frame its parent `{parent}` has; \
         found `{joint}`, which does not"
    )]
    BrokenTree {
        /// Name of the body.
        body: &'static str,
        /// Key of the wrong entry: `origin` or `rotation`.
        key: &'static str,
        /// Name of the joint in that entry.
        joint: String,
        /// Name of the body's parent.
        parent: &'static str,
        /// Name of the joint whose frame the parent has.
        parent_joint: String,
    },
    /// A joint without the end site that the mapping needs.
    #[error("the end of body `{body}` needs an end site on joint `{joint}`")]
    NoEndSite {
        /// Name of the body.
        body: &'static str,
        /// Name of the joint.
        joint: String,
    },
}

/// Formats all mistakes, one per line if there are several, and the skeleton's joints if one is missing.
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

/// A mapping from a recorded skeleton to the figure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "SkeletonMap")]
pub struct Mapping {
    /// Name of the mapping, for messages.
    pub name: String,
    /// Length of the file's unit, in metres, for files that do not contain it.
    pub metres_per_unit: f64,
    /// Frames per second, for files that do not contain the rate.
    pub rate_hz: Option<f64>,
    /// Axis of the files that points up; `None` to infer it from the motion.
    pub up: Option<Up>,
    /// Conditions by which the skeleton is recognized.
    pub signature: Signature,
    /// Joints of each body, in the figure's order.
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

    /// Returns the time between the frames of a recording, in seconds: its own, or else the mapping's. The rate of a
    /// mapping that the user gives (`is_given`) has priority, as its unit has.
    ///
    /// # Errors
    /// [`NoRate`] if neither the recording nor the mapping gives the rate.
    pub fn frame_time_s(&self, recording: &Recording, is_given: bool) -> Result<f64, NoRate> {
        let (own_s, mapped_s) = (recording.frame_time_s, self.rate_hz.map(f64::recip));
        let told_s = if is_given { mapped_s.or(own_s) } else { own_s.or(mapped_s) };
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
