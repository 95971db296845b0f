//! Mapping files (TOML).

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use crate::figure::{BODIES, BODY_COUNT};
use crate::mocap::clip::Skeleton;
use crate::words::in_words;

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
    #[error("{}: {}", file.display(), in_words(source))]
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
#[serde(try_from = "File")]
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
    pub parts: [Part; BODY_COUNT],
}

/// What a skeleton must have and lack to be known.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signature {
    /// Joints that must be there.
    pub joints: Vec<String>,
    /// Joints that must not.
    #[serde(default)]
    pub no_joints: Vec<String>,
    /// Joints that must be there and sit on their parent.
    #[serde(default)]
    pub zero_offsets: Vec<String>,
    /// Joints that must be there and not sit on their parent.
    #[serde(default)]
    pub nonzero_offsets: Vec<String>,
}

impl Signature {
    /// Whether `skeleton` bears this signature, in any unit of length.
    pub fn matches(&self, skeleton: &Skeleton) -> bool {
        let has = |name: &String| skeleton.find(name).is_some();
        let at_parent = |name: &String| {
            skeleton.find(name).map(|j| skeleton.joints[j].offset_m == glam::DVec3::ZERO)
        };
        self.joints.iter().all(has)
            && !self.no_joints.iter().any(has)
            && self.zero_offsets.iter().all(|name| at_parent(name) == Some(true))
            && self.nonzero_offsets.iter().all(|name| at_parent(name) == Some(false))
    }
}

/// What makes one body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// The joint that the body hangs on.
    pub origin: String,
    /// The joint whose frame the body has.
    pub rotation: String,
    /// Where its segment ends.
    pub end: End,
}

/// Where a segment ends, in the skeleton's rest pose.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a joint's name, { site = \"joint\" } or { beyond = \"joint\", ratio = 0.74 }"
)]
pub enum End {
    /// At a joint.
    Joint(String),
    /// At the first end site of a joint.
    Site {
        /// The joint.
        site: String,
    },
    /// On the bone from a joint's parent to the joint, gone on beyond the joint.
    Beyond {
        /// The joint.
        beyond: String,
        /// By how many times the bone's length.
        ratio: f64,
    },
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
            std::fs::read_to_string(path).map_err(|source| Error::Io { file: file(), source })?;
        Self::parse(&text).map_err(|source| Error::Toml { file: file(), source: Box::new(source) })
    }
}

/// The file's own shape.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Option<String>,
    metres_per_unit: Option<f64>,
    rate_hz: Option<f64>,
    signature: Option<Signature>,
    body: Option<BTreeMap<String, Part>>,
}

impl TryFrom<File> for Mapping {
    type Error = String;

    fn try_from(file: File) -> Result<Self, String> {
        // The parser would show line 1 for a key that is missing here.
        fn needed<T>(key: &str, value: Option<T>) -> Result<T, String> {
            value.ok_or_else(|| format!("expected {key}, which is missing"))
        }
        let File { name, metres_per_unit, rate_hz, signature, body } = file;
        let name = needed("`name` before the first table", name)?;
        let metres_per_unit = needed("`metres_per_unit` before the first table", metres_per_unit)?;
        let signature = needed("the table `[signature]`", signature)?;
        let mut body = needed("the table `[body]`", body)?;
        if !(metres_per_unit > 0.0 && metres_per_unit.is_finite()) {
            return Err(format!("metres_per_unit: expected above zero, found {metres_per_unit}"));
        }
        if let Some(rate_hz) = rate_hz
            && !(1.0..=1e5).contains(&rate_hz)
        {
            return Err(format!("rate_hz: expected a number from 1 to 100000, found {rate_hz}"));
        }
        let mut parts = Vec::with_capacity(BODY_COUNT);
        for place in &BODIES {
            let part = body
                .remove(place.name)
                .ok_or_else(|| format!("[body]: expected `{}`, which is missing", place.name))?;
            if let End::Beyond { ratio, .. } = part.end
                && !ratio.is_finite()
            {
                return Err(format!(
                    "body `{}`: ratio: expected finite, found {ratio}",
                    place.name
                ));
            }
            parts.push(part);
        }
        if let Some(stranger) = body.keys().next() {
            let names = BODIES.map(|place| place.name).join(", ");
            return Err(format!("[body]: expected only {names}; found `{stranger}`"));
        }
        let parts = parts.try_into().map_err(|_| "one part for each body".to_owned())?;
        Ok(Self { name, metres_per_unit, rate_hz, signature, parts })
    }
}
