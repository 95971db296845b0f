//! The facts that are shown of a file.

use glam::DVec3;
use serde::Serialize;
use sinew_figure::mapping;
use sinew_figure::measured::Measured;
use sinew_mocap::{Skeleton, axis_name};
use sinew_retarget::Landmark;
use sinew_retarget::skeleton::SkeletonMatch;

use super::maker;

/// The content of a file.
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

/// A joint of the tree that a file holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TreeJoint {
    /// Its name.
    pub name: String,
    /// Which joint of the list it hangs on.
    pub parent: Option<usize>,
    /// Length of the bone from there, m; `None` where the unit is not known.
    pub length_m: Option<f64>,
    /// Of a rig: what the joint leaves free.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves: Option<&'static str>,
}

/// A file, inspected.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Inspected {
    /// The file.
    pub file: String,
    /// Motion, character or rig.
    pub kind: Kind,
    /// The format's name.
    pub format: &'static str,
    /// Who or what wrote it, if the file shows it.
    pub maker: Option<String>,
    /// How many joints it has, all of them.
    pub joints: usize,
    /// How many frames; `None` of what does not move.
    pub frames: Option<usize>,
    /// Frames per second; `None` where the file does not tell.
    pub rate_hz: Option<f64>,
    /// Length of the unit, m; `None` where nothing tells it.
    pub metres_per_unit: Option<f64>,
    /// Why this unit.
    pub unit_reason: String,
    /// The axis that points up.
    pub up: &'static str,
    /// Why this axis.
    pub up_reason: String,
    /// Height of the body standing upright, else the extent along up, m.
    pub height_m: Option<f64>,
    /// Largest extent across up, m.
    pub span_m: Option<f64>,
    /// The known skeleton that is nearest.
    pub nearest: Option<String>,
    /// Joints of that skeleton that it lacks.
    pub missing: Vec<String>,
    /// Parts of a human body that were not found.
    pub landmarks_missing: Vec<&'static str>,
    /// Where it stands in a T-pose.
    pub t_pose: Option<&'static str>,
    /// Samples that are missing.
    pub gaps: usize,
    /// Joints that turn as no human's do, in words.
    pub flips: Option<String>,
    /// What else a person should know.
    pub notes: Vec<String>,
    /// All joints, parents before children.
    pub tree: Vec<TreeJoint>,
}

/// A skeleton that was measured, which every kind of file has.
pub(super) struct Common<'a> {
    pub(super) kind: Kind,
    pub(super) format: &'static str,
    pub(super) maker: Option<String>,
    pub(super) skeleton: &'a Skeleton,
    pub(super) measured: &'a Measured,
    pub(super) matched: &'a SkeletonMatch,
    /// Extents along up and across, in the file's unit.
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
