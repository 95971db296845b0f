//! From landmarks to the figure of 18 bodies: a proposal for a map, as the hand-written ones are.

mod draft;
mod ends;
mod error;
mod note;
mod toml_file;

use std::collections::BTreeMap;

use sinew_mocap::skeleton_map::{End, Signature};
use sinew_mocap::{Skeleton, SkeletonMap};

pub use error::FigureMappingError;
pub use note::Note;

use draft::{Draft, Proposed};
use ends::Ends;

use super::SkeletonMatch;
use super::body::Body;
use crate::{Landmark, Side};

/// A proposal for a map on the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureMapping {
    /// The map.
    pub map: SkeletonMap,
    /// How sure each body is, in the figure's order.
    pub notes: Vec<Note>,
    /// What a person should know of the whole.
    pub findings: Vec<String>,
}

/// What to call a map, and what its file tells beside the bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapHead<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// Length of the file's unit, in metres: see [`SkeletonMatch::unit`].
    pub metres_per_unit: f64,
    /// Frames per second, for files that do not tell them.
    pub rate_hz: Option<f64>,
}

/// Where the head of `skeleton` ends, and a remark if the file does not tell it; `None` without a head.
pub fn head_end(skeleton: &Skeleton, matched: &SkeletonMatch) -> Option<(End, Option<String>)> {
    let head = matched.joint(Landmark::Head)?;
    (matched.height() > 0.0)
        .then(|| Ends::new(&Body::new(skeleton, &[]), matched.height()).head(head))
}

/// The map of `skeleton` on the figure of 18 bodies, by the landmarks of `matched`.
///
/// # Errors
/// [`FigureMappingError`] names every landmark that is missing.
pub fn figure_mapping(
    skeleton: &Skeleton,
    matched: &SkeletonMatch,
    head: MapHead<'_>,
) -> Result<FigureMapping, FigureMappingError> {
    let draft = Draft::new(skeleton, matched)?;
    let mut bodies = draft.trunk();
    for side in Side::ALL {
        bodies.extend(draft.arm(side));
    }
    for side in Side::ALL {
        bodies.extend(draft.leg(side));
    }
    let signature = signature(skeleton, &bodies)?;
    let notes = bodies.iter().map(|body| body.note.clone()).collect();
    let map = SkeletonMap {
        name: head.name.to_owned(),
        metres_per_unit: head.metres_per_unit,
        rate_hz: head.rate_hz,
        up: None,
        signature,
        bodies: bodies
            .into_iter()
            .map(|body| (body.note.body, body.part))
            .collect::<BTreeMap<_, _>>(),
    };
    Ok(FigureMapping { map, notes, findings: matched.findings.clone() })
}

/// By what the skeleton is known again: all joints that the map names; neck and clavicles at their parents or not, by
/// which CMU's conversions differ.
fn signature(skeleton: &Skeleton, bodies: &[Proposed]) -> Result<Signature, FigureMappingError> {
    let ends = bodies.iter().map(|body| match &body.part.end {
        End::Joint(joint) | End::Site { site: joint } | End::Beyond { beyond: joint, .. } => joint,
    });
    let used = bodies.iter().flat_map(|body| [&body.part.origin, &body.part.rotation]).chain(ends);
    let used: std::collections::BTreeSet<&String> = used.collect();
    let mut joints = Vec::new();
    for joint in skeleton.joints.iter().filter(|joint| used.contains(&joint.name)) {
        if joints.contains(&joint.name) {
            return Err(FigureMappingError::SameName(joint.name.clone()));
        }
        joints.push(joint.name.clone());
    }
    let lies = |at_parent: bool| {
        let of = bodies
            .iter()
            .filter(|body| body.note.body == "head" || body.note.body.starts_with("clavicle"));
        let mut names: Vec<String> = of.map(|body| body.part.origin.clone()).collect();
        names.dedup();
        names.retain(|name| {
            let found = skeleton.find(name).map(|joint| &skeleton.joints[joint]);
            found.is_some_and(|joint| {
                joint.parent.is_some() && (joint.offset_m == glam::DVec3::ZERO) == at_parent
            })
        });
        names
    };
    Ok(Signature {
        joints,
        no_joints: Vec::new(),
        zero_offsets: lies(true),
        nonzero_offsets: lies(false),
    })
}
