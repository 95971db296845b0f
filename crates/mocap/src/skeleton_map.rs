//! Defines the bodies of another figure by a skeleton's joints.
//!
//! A map is data, usually a file: for each body, by name, the joint at its origin, the joint whose frame it has,
//! and the end of its segment. The figure determines which bodies are needed.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use crate::{Skeleton, Up};

/// A map from a recorded skeleton to a figure.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(try_from = "File")]
pub struct SkeletonMap {
    /// Name for messages.
    pub name: String,
    /// Length of the file's unit, in metres, for files that do not contain it.
    pub metres_per_unit: f64,
    /// Frame rate, Hz, for files that do not contain it; `None` if it is unknown.
    pub rate_hz: Option<f64>,
    /// Axis of the files that points up; `None` to derive it from the motion.
    pub up: Option<Up>,
    /// Properties by which the skeleton is recognized.
    pub signature: Signature,
    /// Joints of each body, by the body's name.
    pub bodies: BTreeMap<String, BodyJoints>,
}

/// Properties that a skeleton must have, and must not have, to be recognized.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Signature {
    /// Joints that must exist.
    pub joints: Vec<String>,
    /// Joints that must not exist.
    #[serde(default)]
    pub no_joints: Vec<String>,
    /// Joints that must exist at the position of their parent.
    #[serde(default)]
    pub zero_offsets: Vec<String>,
    /// Joints that must exist at a distance from their parent.
    #[serde(default)]
    pub nonzero_offsets: Vec<String>,
}

impl Signature {
    /// Returns whether `skeleton` has this signature, in any unit of length and with any [`prefix`](Self::prefix).
    pub fn matches(&self, skeleton: &Skeleton) -> bool {
        self.prefix(skeleton).is_some()
    }

    /// Returns the common prefix of the signature's names in `skeleton`: usually empty, otherwise the name of a
    /// character or a file (`mixamorig7:`). `None` if the skeleton does not have the signature.
    pub fn prefix<'s>(&self, skeleton: &'s Skeleton) -> Option<&'s str> {
        let Some(first) = self.joints.first() else {
            return self.is_borne(skeleton, "").then_some("");
        };
        let mut prefixes: Vec<&str> = skeleton
            .joints
            .iter()
            .filter_map(|joint| joint.name.strip_suffix(first.as_str()))
            .collect();
        prefixes.sort_by_key(|prefix| prefix.len());
        prefixes.into_iter().find(|prefix| self.is_borne(skeleton, prefix))
    }

    fn is_borne(&self, skeleton: &Skeleton, prefix: &str) -> bool {
        let find = |name: &String| skeleton.find(&format!("{prefix}{name}"));
        let at_parent =
            |name: &String| find(name).map(|j| skeleton.joints[j].offset_m == DVec3::ZERO);
        self.joints.iter().all(|name| find(name).is_some())
            && !self.no_joints.iter().any(|name| find(name).is_some())
            && self.zero_offsets.iter().all(|name| at_parent(name) == Some(true))
            && self.nonzero_offsets.iter().all(|name| at_parent(name) == Some(false))
    }
}

/// The joints that define one body.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BodyJoints {
    /// Joint at the origin of the body.
    pub origin: String,
    /// Joint whose frame the body has.
    pub rotation: String,
    /// End of the body's segment.
    pub end: End,
}

/// End of a segment, in the skeleton's rest pose.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(
    untagged,
    deny_unknown_fields,
    expecting = "expected a joint's name, { site = \"joint\" } or { beyond = \"joint\", ratio = 0.74 }"
)]
pub enum End {
    /// At the position of a joint.
    Joint(String),
    /// At the first end site of a joint.
    Site {
        /// Name of the joint.
        site: String,
    },
    /// Beyond a joint, on the extension of the bone from its parent.
    Beyond {
        /// Name of the joint.
        beyond: String,
        /// Distance beyond the joint, in multiples of the bone's length.
        ratio: f64,
    },
}

impl End {
    /// Returns the position of the end in the rest pose of `skeleton`, whose joints are at `rest_m`, in metres.
    ///
    /// # Errors
    /// [`MissingEnd`] if the skeleton does not have the named joint or end site.
    pub fn rest_position_m(
        &self,
        skeleton: &Skeleton,
        rest_m: &[DVec3],
    ) -> Result<DVec3, MissingEnd> {
        self.behind("", skeleton, rest_m)
    }

    /// Returns the position like [`Self::rest_position_m`], with `prefix` before the joint's name.
    ///
    /// # Errors
    /// [`MissingEnd`] if the skeleton does not have the named joint or end site.
    pub fn behind(
        &self,
        prefix: &str,
        skeleton: &Skeleton,
        rest_m: &[DVec3],
    ) -> Result<DVec3, MissingEnd> {
        let find = |name: &str| {
            let found = skeleton.find(&format!("{prefix}{name}"));
            found.ok_or_else(|| MissingEnd::Joint(name.to_owned()))
        };
        Ok(match self {
            Self::Joint(joint) => rest_m[find(joint)?],
            Self::Site { site } => {
                let joint = find(site)?;
                let ends = &skeleton.joints[joint].end_sites_m;
                rest_m[joint] + *ends.first().ok_or_else(|| MissingEnd::Site(site.clone()))?
            }
            Self::Beyond { beyond, ratio } => {
                let joint = find(beyond)?;
                rest_m[joint] + *ratio * skeleton.joints[joint].offset_m
            }
        })
    }
}

/// The reason why the end of a segment does not exist in a skeleton.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum MissingEnd {
    /// The joint does not exist.
    #[error("expected a joint `{0}`")]
    Joint(String),
    /// The joint has no end site.
    #[error("expected an end site on joint `{0}`")]
    Site(String),
}

/// The structure of the file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    name: Option<String>,
    metres_per_unit: Option<f64>,
    rate_hz: Option<f64>,
    up: Option<Up>,
    signature: Option<Signature>,
    body: Option<BTreeMap<String, BodyJoints>>,
}

impl TryFrom<File> for SkeletonMap {
    type Error = String;

    fn try_from(file: File) -> Result<Self, String> {
        // Checked here, because the parser would report line 1 for a missing key.
        fn needed<T>(key: &str, value: Option<T>) -> Result<T, String> {
            value.ok_or_else(|| format!("expected {key}, which is missing"))
        }
        let File { name, metres_per_unit, rate_hz, up, signature, body } = file;
        let name = needed("`name` before the first table", name)?;
        let metres_per_unit = needed("`metres_per_unit` before the first table", metres_per_unit)?;
        let signature = needed("the table `[signature]`", signature)?;
        let bodies = needed("the table `[body]`", body)?;
        if !(metres_per_unit > 0.0 && metres_per_unit.is_finite()) {
            return Err(format!("metres_per_unit: expected above zero, found {metres_per_unit}"));
        }
        if let Some(rate_hz) = rate_hz
            && !(1.0..=1e5).contains(&rate_hz)
        {
            return Err(format!("rate_hz: expected a number from 1 to 100000, found {rate_hz}"));
        }
        for (name, part) in &bodies {
            if let End::Beyond { ratio, .. } = part.end
                && !ratio.is_finite()
            {
                return Err(format!("body `{name}`: ratio: expected finite, found {ratio}"));
            }
        }
        Ok(Self { name, metres_per_unit, rate_hz, up, signature, bodies })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SkeletonJoint;

    const MAP: &str = "name = 'arm'\nmetres_per_unit = 0.01\n[signature]\njoints = ['a', 'b']\nzero_offsets = ['a']\n\
        [body]\nupper = { origin = 'a', rotation = 'a', end = 'b' }\n\
        lower = { origin = 'b', rotation = 'b', end = { beyond = 'b', ratio = 0.5 } }\n";

    fn skeleton() -> Skeleton {
        let joint = |name: &str, parent, offset_m| SkeletonJoint {
            name: name.to_owned(),
            parent,
            offset_m,
            end_sites_m: Vec::new(),
        };
        Skeleton { joints: vec![joint("a", None, DVec3::ZERO), joint("b", Some(0), DVec3::Y)] }
    }

    #[test]
    fn a_map_is_read_and_knows_its_skeleton() {
        let map: SkeletonMap = toml::from_str(MAP).unwrap();
        let mut skeleton = skeleton();
        assert!(map.signature.matches(&skeleton));
        let rest_m = skeleton.rest_positions_m();
        let end_m = |body: &str| map.bodies[body].end.rest_position_m(&skeleton, &rest_m);
        assert_eq!(end_m("upper"), Ok(DVec3::Y));
        assert_eq!(end_m("lower"), Ok(1.5 * DVec3::Y));
        let site = End::Site { site: "b".to_owned() };
        assert_eq!(site.rest_position_m(&skeleton, &rest_m), Err(MissingEnd::Site("b".to_owned())));
        for (joint, name) in skeleton.joints.iter_mut().zip(["rig7:a", "rig7:b"]) {
            name.clone_into(&mut joint.name);
        }
        assert_eq!(map.signature.prefix(&skeleton), Some("rig7:"));
        let rest_m = skeleton.rest_positions_m();
        assert_eq!(map.bodies["lower"].end.behind("rig7:", &skeleton, &rest_m), Ok(1.5 * DVec3::Y));
        skeleton.joints[0].offset_m = DVec3::X;
        assert!(!map.signature.matches(&skeleton));
        // Different prefixes are not a common prefix.
        "b".clone_into(&mut skeleton.joints[1].name);
        skeleton.joints[0].offset_m = DVec3::ZERO;
        assert_eq!(map.signature.prefix(&skeleton), None);
    }

    #[test]
    fn numbers_that_cannot_be_are_refused() {
        for (what, with, expected) in [
            ("0.01", "0", "metres_per_unit: expected above zero"),
            ("0.5", "nan", "body `lower`: ratio: expected finite, found NaN"),
            ("name = 'arm'\n", "", "expected `name` before the first table"),
        ] {
            let error = toml::from_str::<SkeletonMap>(&MAP.replace(what, with)).unwrap_err();
            assert!(error.to_string().contains(expected), "{error}");
        }
    }
}
