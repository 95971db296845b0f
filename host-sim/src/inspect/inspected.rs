//! Facts about a file that are shown.

use glam::DVec3;
use serde::Serialize;
use sinew_figure::mapping;
use sinew_figure::measured::Measured;
use sinew_mocap::{Skeleton, axis_name};
use sinew_retarget::Landmark;
use sinew_retarget::skeleton::SkeletonMatch;

use super::maker;

/// The kind of content of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Kind {
    /// A skeleton that moves.
    Motion,
    /// A skeleton at rest, with or without a skin.
    Character,
    /// Bodies with mass, and joints with limits.
    Rig,
}

/// A joint of the tree in a file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TreeJoint {
    /// Name of the joint.
    pub name: String,
    /// Index of the parent joint in the list; `None` for a root.
    pub parent: Option<usize>,
    /// Distance from the parent joint, m; `None` if the unit is unknown.
    pub length_m: Option<f64>,
    /// The motion that a rig's joint allows; `None` for other files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves: Option<&'static str>,
}

/// Facts about an inspected file.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Inspected {
    /// Path of the file.
    pub file: String,
    /// Motion, character or rig.
    pub kind: Kind,
    /// Name of the file format.
    pub format: &'static str,
    /// The program or company that wrote the file, if known.
    pub maker: Option<String>,
    /// Number of joints.
    pub joints: usize,
    /// Number of frames; `None` if the file has no motion.
    pub frames: Option<usize>,
    /// Frames per second; `None` if the file does not contain the rate.
    pub rate_hz: Option<f64>,
    /// Length of the file's unit, m; `None` if unknown.
    pub metres_per_unit: Option<f64>,
    /// Reason for this unit.
    pub unit_reason: String,
    /// The axis that points up.
    pub up: &'static str,
    /// Reason for this axis.
    pub up_reason: String,
    /// Height of the body if it stands upright, otherwise the extent along the up axis, m; `None` if the unit is
    /// unknown.
    pub height_m: Option<f64>,
    /// Largest extent across the up axis, m; `None` if the unit is unknown.
    pub span_m: Option<f64>,
    /// The nearest known skeleton; `None` for a rig, and if no skeleton is near.
    pub nearest: Option<String>,
    /// Joints of that skeleton that the file lacks.
    pub missing: Vec<String>,
    /// Parts of a human body that were not found.
    pub landmarks_missing: Vec<&'static str>,
    /// Place of a T-pose in the file; `None` if there is no T-pose.
    pub t_pose: Option<&'static str>,
    /// Number of missing samples.
    pub gaps: usize,
    /// Joints that turn in a way that human joints cannot, as text; `None` if there are none.
    pub flips: Option<String>,
    /// Other notes for the user.
    pub notes: Vec<String>,
    /// All joints, parents before children.
    pub tree: Vec<TreeJoint>,
}

/// A measured skeleton: the facts that every kind of file has.
pub(super) struct Common<'a> {
    pub(super) kind: Kind,
    pub(super) format: &'static str,
    pub(super) maker: Option<String>,
    pub(super) skeleton: &'a Skeleton,
    pub(super) measured: &'a Measured,
    pub(super) matched: &'a SkeletonMatch,
    /// Extents along and across the up axis, in the file's unit.
    pub(super) extents: [f64; 2],
}

impl Common<'_> {
    pub(super) fn inspected(self) -> Inspected {
        let Self { kind, format, maker, skeleton, measured, matched, extents } = self;
        let unit = measured.metres_per_unit;
        let (nearest, missing) = match mapping::find_nearest(skeleton) {
            Some((mapping, lacking)) => (
                Some(mapping.name.clone()),
                lacking.iter().map(|name| (*name).to_owned()).collect(),
            ),
            None => (None, Vec::new()),
        };
        let lacks = |landmark: &Landmark| matched.joint(*landmark).is_none();
        let length = |offset: DVec3| unit.map(|unit| unit * offset.length());
        Inspected {
            file: String::new(),
            kind,
            format,
            maker: maker.or_else(|| maker::by_names(skeleton).map(str::to_owned)),
            joints: skeleton.joints.len(),
            frames: None,
            rate_hz: None,
            metres_per_unit: unit,
            unit_reason: measured.unit_reason.clone(),
            up: axis_name(measured.up.axis),
            up_reason: measured.up.reason.clone(),
            height_m: measured.height_m(),
            span_m: unit.map(|unit| unit * extents[1]),
            nearest,
            missing,
            landmarks_missing: Landmark::ALL
                .iter()
                .filter(|k| lacks(k))
                .map(|k| k.name())
                .collect(),
            t_pose: None,
            gaps: 0,
            flips: None,
            notes: measured
                .warnings()
                .into_iter()
                .chain(matched.findings.iter().cloned())
                .collect(),
            tree: skeleton
                .joints
                .iter()
                .map(|joint| TreeJoint {
                    name: joint.name.clone(),
                    parent: joint.parent,
                    length_m: joint.parent.and(length(joint.offset_m)),
                    moves: None,
                })
                .collect(),
        }
    }
}
