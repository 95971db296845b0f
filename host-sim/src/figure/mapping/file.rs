//! Mapping files (TOML).

use std::path::{Path, PathBuf};

use serde::Deserialize;
use sinew_mocap::SkeletonMap;
use sinew_mocap::skeleton_map::{Part, Signature};

use crate::figure::{BODIES, BODY_COUNT};
use crate::parse_message::parse_message;

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
    /// The skeleton is unknown.
    #[error(
        "no known skeleton has the joints {found} (tried: {tried}).{nearest} Write a mapping file after the \
         pattern of host-sim/mappings/*.toml and give it with --mapping"
    )]
    NoneMatches {
        /// The skeleton's joints.
        found: String,
        /// Names of the mappings.
        tried: String,
        /// A sentence on the nearest one, or nothing.
        nearest: String,
    },
    /// Two mappings claim the same skeleton.
    #[error("the skeleton fits several mappings ({names}); give one of them with --mapping")]
    SeveralMatch {
        /// Names of the mappings.
        names: String,
    },
    /// The mapping is for another skeleton.
    #[error("mapping `{mapping}`: body `{body}` needs joint `{joint}`, but the clip has {found}")]
    NoSuchJoint {
        /// Name of the mapping.
        mapping: String,
        /// Name of the body.
        body: &'static str,
        /// The joint that is missing.
        joint: String,
        /// The skeleton's joints.
        found: String,
    },
    /// A body would not move with its parent.
    #[error(
        "mapping `{mapping}`: body `{body}`, {key}: expected a joint that moves with `{parent_joint}`, whose \
         frame its parent `{parent}` has; found `{joint}`, which does not"
    )]
    BrokenTree {
        /// Name of the mapping.
        mapping: String,
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
    #[error("mapping `{mapping}`: the end of body `{body}` needs an end site on joint `{joint}`")]
    NoEndSite {
        /// Name of the mapping.
        mapping: String,
        /// Name of the body.
        body: &'static str,
        /// The joint without one.
        joint: String,
    },
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
    /// How the skeleton is known.
    pub signature: Signature,
    /// What makes each body, in the figure's order.
    pub parts: Vec<Part>,
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
        let text =
            sinew_mocap::read::text(path).map_err(|source| Error::Io { file: file(), source })?;
        Self::parse(&text).map_err(|source| Error::Toml { file: file(), source: Box::new(source) })
    }
}

impl TryFrom<SkeletonMap> for Mapping {
    type Error = String;

    fn try_from(map: SkeletonMap) -> Result<Self, String> {
        let SkeletonMap { name, metres_per_unit, rate_hz, signature, mut bodies } = map;
        let mut parts = Vec::with_capacity(BODY_COUNT);
        for place in &BODIES {
            let part = bodies
                .remove(place.name)
                .ok_or_else(|| format!("[body]: expected `{}`, which is missing", place.name))?;
            parts.push(part);
        }
        if let Some(stranger) = bodies.keys().next() {
            let names = BODIES.map(|place| place.name).join(", ");
            return Err(format!("[body]: expected only {names}; found `{stranger}`"));
        }
        Ok(Self { name, metres_per_unit, rate_hz, signature, parts })
    }
}
