//! Proposes a map from a skeleton's landmarks onto the figure of 18 bodies, in the format of the hand-written maps.

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

/// A proposed map onto the figure.
#[derive(Debug, Clone, PartialEq)]
pub struct FigureMapping {
    /// The proposed map.
    pub map: SkeletonMap,
    /// Confidence of each body, in the figure's order.
    pub notes: Vec<Note>,
    /// Findings about the skeleton as a whole.
    pub findings: Vec<String>,
}

/// Name of a map, and its properties other than bodies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapHead<'a> {
    /// Name for messages.
    pub name: &'a str,
    /// Length of the file's unit, in metres: see [`SkeletonMatch::unit`].
    pub metres_per_unit: f64,
    /// Frame rate, Hz, for files that do not contain it.
    pub rate_hz: Option<f64>,
}

/// Returns the end of the head of `skeleton`, with a remark if it is not in the file; `None` if the head was not found,
/// or the height of the body is unknown.
pub fn head_end(skeleton: &Skeleton, matched: &SkeletonMatch) -> Option<(End, Option<String>)> {
    let head = matched.joint(Landmark::Head)?;
    (matched.height() > 0.0)
        .then(|| Ends::new(&Body::new(skeleton, &[]), matched.height()).head(head))
}

/// Returns the map of `skeleton` onto the figure of 18 bodies, from the landmarks of `matched`.
///
/// # Errors
/// [`FigureMappingError`] names every missing landmark.
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

/// Returns the signature by which the skeleton is recognized: all joints that the map names, and whether neck and
/// clavicles are at their parents' positions, which distinguishes conversions of CMU files.
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
